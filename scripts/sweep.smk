# Runs a suite of balance in shards, on the cores of one machine or on the nodes of a cluster, and merges them: docs/cluster.md.
#
#   snakemake --snakefile scripts/sweep.smk --cores 4 --config suite=suite.yaml shards=8 out=results
#
# A shard that was killed is tried again (--retries, three times unless said otherwise) and goes on where it stopped. Cases that fail
# for good reasons (exit codes 1, 3, 4), or because they crashed or went beyond a limit (status "failed", exit code 5), are no reason
# to try again: the summary tells of them, and so does verdict.txt, which holds the exit code that `balance batch` would have had.

import json
import subprocess

SUITE = config["suite"]
OUT = config.get("out", "results")
SHARDS = int(config.get("shards", 4))
BALANCE = config.get("balance", "balance")
RETRIES = int(config.get("retries", 3))
OPTIONS = config.get("options", "")

# The suite, its specs and their tables: when one of them changes, shards run again and compute what is no longer finished.
listed = subprocess.run([BALANCE, "batch", SUITE, "--list", "--json"], capture_output=True, text=True)
if listed.returncode != 0:
    raise WorkflowError(listed.stderr or listed.stdout)
FILES = json.loads(listed.stdout)["files"]


rule all:
    input:
        OUT + "/verdict.txt"


rule shard:
    input:
        FILES
    output:
        touch(OUT + "/.shards/{index}-of-" + str(SHARDS))
    params:
        balance=BALANCE,
        suite=SUITE,
        out=OUT,
        of=SHARDS,
        options=OPTIONS
    retries: RETRIES
    threads: 1
    shell:
        """
        code=0
        told=$({params.balance:q} batch {params.suite:q} -o {params.out:q} -j {threads} --shard {wildcards.index}/{params.of} \
          -q --json --force {params.options}) || code=$?
        case $code-$told in
          [0134]-*) ;;
          *'"status": "system"'*) echo "$told"; exit $code ;;
          5-*'"shard":'*) ;;
          *) exit $code ;;
        esac
        """


rule merge:
    input:
        expand(OUT + "/.shards/{index}-of-" + str(SHARDS), index=range(1, SHARDS + 1))
    output:
        OUT + "/verdict.txt"
    params:
        balance=BALANCE,
        suite=SUITE,
        out=OUT
    shell:
        """
        code=0
        told=$({params.balance:q} batch {params.suite:q} -o {params.out:q} --merge --json) || code=$?
        case $code-$told in
          [0134]-*) ;;
          *'"status": "missing"'*) echo "$told"; exit $code ;;
          5-*'"exit_code": 5'*) ;;
          *) exit $code ;;
        esac
        cat {params.out:q}/summary.md
        echo $code > {output:q}
        """
