// The account page: a web hook is set, tested and removed. account.mjs LINK URL, the latter one that answers; PICTURES=folder keeps pictures.
import { Browser, sleep } from "./browser.mjs";

const [link, url] = process.argv.slice(2);
if (!url) throw new Error("account.mjs LINK URL");
const browser = await Browser.start();
try {
  await browser.look(1366, 768, false);
  await browser.open(link);
  await browser.until(`document.getElementById("who")?.innerText`, "not logged in");
  await browser.open(`${new URL(link).origin}/account`);
  const field = `document.querySelector("[aria-label='URL of the web hook']")`;
  const set = async (/** @type {string} */ to) => {
    await browser.until(field, "no field of the web hook");
    await browser.run(`${field}.value = ${JSON.stringify(to)}`);
    await browser.click("Save");
  };
  await set("https://127.0.0.1/");
  await browser.until(`document.querySelector(".toast.bad")?.innerText.includes("no public address")`, "no word about the address");
  await set(url);
  await browser.until(`[...document.querySelectorAll("code")].some((one) => /^[0-9a-f]{64}$/.test(one.innerText))`, "no secret");
  await browser.click("Send a test");
  await sleep(1500);
  await browser.click("Look again");
  await browser.until(`[...document.querySelectorAll("td")].some((one) => one.innerText === "delivered")`, "not delivered");
  for (const [name, width, height, dark, phone] of [["light", 1366, 768, false, false], ["dark", 1366, 768, true, false], ["phone", 390, 844, false, true]]) {
    await browser.look(width, height, dark, phone);
    await browser.run(`${field}.scrollIntoView({ block: "center" })`);
    await browser.picture(`account-${name}.png`);
    if (await browser.run(`document.documentElement.scrollWidth > innerWidth`)) throw new Error(`the page is wider than ${width}`);
  }
  await browser.look(1366, 768, false);
  await browser.click("Remove");
  await browser.until(`document.querySelector("dialog[open]")`, "no question");
  await browser.run(`document.querySelector("dialog button.main").click()`);
  await browser.until(`document.body.innerText.includes("can be sent to a URL") && !document.body.innerText.includes("delivered")`, "not removed");
  const complaints = browser.complaints.filter((one) => !one.includes("400"));
  if (complaints.length) throw new Error(`the console complains:\n${complaints.join("\n")}`);
  console.log("refused, set, tested, removed");
} finally {
  await browser.stop();
}
