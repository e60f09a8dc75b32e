#!/usr/bin/env bash
# One afternoon in a real account: what moto cannot show. Costs less than a dollar, and takes about 40 minutes.
# smoke.sh IMAGE VPC SUBNET,SUBNET — needs aws (version 2) with credentials that may make the stack, mercury-cloud built with
# --features aws, mercury-solve, python3. IMAGE is in ECR already (docs/how-to/cloud-aws.md). Leaves the bucket, and says so.
set -euo pipefail
image="$1" vpc="$2" subnets="$3"
here="$(cd "$(dirname "$0")" && pwd)"
root="$(cd "$here/../../.." && pwd)"
PATH="$root/cloud/target/release:$root/target/release:$PATH"
stack="mercury-smoke-$(date +%s)"
scratch="$(mktemp -d)"
passed=0
say() { printf '%s  %s\n' "$(date +%T)" "$*"; }
step() { passed=$((passed + 1)); say "passed $passed: $*"; }
end() {
  code=$?
  [ -n "${server:-}" ] && kill "$server" 2> /dev/null
  say "removing the stack $stack (its bucket stays: ${bucket:-none})"
  aws cloudformation delete-stack --stack-name "$stack"
  aws cloudformation wait stack-delete-complete --stack-name "$stack" || say "the stack $stack could NOT be removed: look at it"
  [ "$code" = 0 ] && say "all $passed steps passed" || say "FAILED after step $passed; the log of the server is $scratch/server.log"
}
trap end EXIT

aws cloudformation deploy --stack-name "$stack" --template-file "$here/mercury-cloud.yaml" --capabilities CAPABILITY_IAM \
  --parameter-overrides "Image=$image" "Vpc=$vpc" "Subnets=$subnets" SpotCores=8 OnDemandCores=4
step "the stack is created"
output() { aws cloudformation describe-stacks --stack-name "$stack" --query "Stacks[0].Outputs[?OutputKey=='$1'].OutputValue" --output text; }
bucket="$(output Bucket)"
printf 'queues = ["%s", "%s"]\ndefinition = "%s"\n' "$(output SpotQueueArn)" "$(output OnDemandQueueArn)" "$(output WorkerArn)" > "$scratch/batch.toml"

# Credentials as variables, which is where the program reads them.
eval "$(aws configure export-credentials --format env)"
AWS_REGION="${AWS_REGION:-$(aws configure get region)}"
export AWS_REGION
mercury-cloud serve --data "$scratch/data" --store "$(output StoreUrl)" --aws "$scratch/batch.toml" --port 18080 --checkpoint-every 30s \
  > "$scratch/link" 2> "$scratch/server.log" &
server=$!
for _ in $(seq 60); do [ -s "$scratch/link" ] && break; sleep 1; done
MERCURY_CLOUD_LINK="$(head -n 1 "$scratch/link")"
export MERCURY_CLOUD_LINK
step "the bucket does conditional writes, and the server is up"

field() { mercury-cloud ls --json | python3 -c "import json, sys; print(next(run[sys.argv[2]] for run in json.load(sys.stdin) if run['id'] == sys.argv[1]))" "$1" "$2"; }
until_is() { # RUN FIELD VALUE MINUTES
  for _ in $(seq $((6 * $4))); do [ "$(field "$1" "$2")" = "$3" ] && return; sleep 10; done
  say "$2 of $1 is $(field "$1" "$2"), not $3, after $4 min"; return 1
}
cd "$scratch"
mercury-solve new drum > /dev/null
mercury-solve drum.toml --set time.end=1 --set output.pictures=false --quiet --output alone
run="$(mercury-cloud submit drum.toml --set time.end=1 --set output.pictures=false)"
until_is "$run" state finished 20
mercury-cloud get "$run" -o first && mercury-cloud diff alone first
step "a run on a spot machine has the bytes of this machine"

run="$(mercury-cloud submit drum.toml --set time.end=20 --set output.pictures=false)"
until_is "$run" state running 20
for _ in $(seq 60); do [ "$(field "$run" step)" != 0 ] && break; sleep 10; done
mercury-cloud stop "$run"
until_is "$run" state stopped 5
mercury-cloud resume "$run"
until_is "$run" state running 5
step "stopped and resumed from the command line"

# SIGTERM of Batch, and its 30 s.
job="$(aws batch list-jobs --job-queue "$(output SpotQueueArn)" --filters "name=JOB_NAME,values=mc-$run-*" --query 'jobSummaryList[?status==`RUNNING`].jobId' --output text)"
before="$(field "$run" step)"
aws batch terminate-job --job-id "$job" --reason "smoke test"
for _ in $(seq 30); do [ "$(field "$run" epoch)" -ge 3 ] && break; sleep 10; done
[ "$(field "$run" epoch)" -ge 3 ] && [ "$(field "$run" step)" -ge "$before" ]
step "a terminated job commits within its 30 s, and another attempt goes on"

# A machine that is taken away with its notice of two minutes: a spot interruption by the Fault Injection Service is the way to
# make one; here the instance is ended, which gives no notice at all.
instance="$(aws ec2 describe-instances --filters Name=tag:aws:batch:compute-environment,Values='*' Name=instance-state-name,Values=running --query 'Reservations[0].Instances[0].InstanceId' --output text)"
epoch="$(field "$run" epoch)"
aws ec2 terminate-instances --instance-ids "$instance" > /dev/null
for _ in $(seq 60); do [ "$(field "$run" epoch)" -gt "$epoch" ] && break; sleep 10; done
[ "$(field "$run" epoch)" -gt "$epoch" ]
step "an instance that is ended without notice loses its attempt, and another one is made"
mercury-cloud kill "$run"
until_is "$run" state cancelled 5 || until_is "$run" state stopped 1
aws s3 rm --quiet --recursive "s3://$bucket"
