// Amounts of money.

/** An amount, with as many digits as it needs. @param {number} amount @param {{currency: string} | null | undefined} of */
export function money(amount, of) {
  const digits = amount >= 100 ? 0 : amount >= 0.1 || amount === 0 ? 2 : Math.min(6, 1 - Math.floor(Math.log10(amount)));
  return `${amount.toFixed(digits)} ${of?.currency ?? ""}`.trim();
}

/** Cost of so many core seconds. @param {number} coreSeconds @param {{currency: string, core_hour: number}} of */
export const price = (coreSeconds, of) => money((coreSeconds / 3600) * of.core_hour, of);
