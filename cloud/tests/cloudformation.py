"""The template of deploy/aws is linted, and a stack of it is created, updated and deleted in moto, which knows what resources
are and not whether they work together. Run by the python that has moto, boto3 and cfn-lint: cloudformation.py PORT, of moto's
server."""

import subprocess
import sys
from pathlib import Path

import boto3

TEMPLATE = Path(__file__).resolve().parents[1] / "deploy/aws/mercury-cloud.yaml"


def main(port):
    lint = [str(Path(sys.executable).parent / "cfn-lint"), "--regions", "eu-central-1", "us-east-1", "--include-checks", "I", "--", str(TEMPLATE)]
    subprocess.run(lint, check=True)
    client = lambda name: boto3.client(name, endpoint_url=f"http://127.0.0.1:{port}", region_name="eu-central-1",
                                       aws_access_key_id="test", aws_secret_access_key="test")
    formation, batch, ec2, s3 = (client(name) for name in ("cloudformation", "batch", "ec2", "s3"))
    network = ec2.describe_vpcs()["Vpcs"][0]["VpcId"]
    subnets = [subnet["SubnetId"] for subnet in ec2.describe_subnets()["Subnets"]][:2]
    # AWS makes the role of the service by itself where none is named, and needs that one for updates in place. moto does not.
    iam = client("iam")
    role = iam.create_role(RoleName="batch", AssumeRolePolicyDocument="{}")["Role"]["Arn"]
    text = TEMPLATE.read_text().replace("      ReplaceComputeEnvironment: false\n", f"      ServiceRole: {role}\n")
    # Nor does it split lists in parameters.
    text = text.replace("InstanceTypes: !Ref InstanceTypes", "InstanceTypes: [c5.large, m5.large]")
    parameters = lambda **more: [{"ParameterKey": key, "ParameterValue": value} for key, value in
                                 ({"Image": "example/mercury:1", "Vpc": network, "Subnets": ",".join(subnets)} | more).items()]
    stack = lambda: formation.describe_stacks(StackName="mercury")["Stacks"][0]
    formation.create_stack(StackName="mercury", TemplateBody=text, Parameters=parameters(), Capabilities=["CAPABILITY_IAM"])
    assert stack()["StackStatus"] == "CREATE_COMPLETE", stack()
    found = {output["OutputKey"]: output["OutputValue"] for output in stack()["Outputs"]}
    assert set(found) == {"StoreUrl", "Bucket", "SpotQueueArn", "OnDemandQueueArn", "WorkerArn", "ServerPolicyArn"}, found
    definition = batch.describe_job_definitions(jobDefinitions=[found["WorkerArn"]])["jobDefinitions"][0]
    assert definition["retryStrategy"]["attempts"] == 1, definition
    environments = batch.describe_compute_environments()["computeEnvironments"]
    kinds = sorted(one["computeResources"]["type"] for one in environments)
    assert kinds == ["EC2", "SPOT"], environments
    assert len(batch.describe_job_queues()["jobQueues"]) == 2
    formation.update_stack(StackName="mercury", TemplateBody=text, Parameters=parameters(LogDays="7", Image="example/mercury:2"),
                           Capabilities=["CAPABILITY_IAM"])
    assert stack()["StackStatus"] == "UPDATE_COMPLETE", stack()
    formation.delete_stack(StackName="mercury")
    left = formation.list_stacks(StackStatusFilter=["CREATE_COMPLETE", "UPDATE_COMPLETE"])["StackSummaries"]
    assert not left, left
    print(f"    created, updated and deleted in moto: {', '.join(sorted(found))}")


main(sys.argv[1])
