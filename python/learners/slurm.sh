#!/bin/bash
# Jobs for Slurm, submitted from the repository's folder, which all nodes share:
#
#   sbatch python/learners/slurm.sh learn --id ShellGameTouch-VLA-v0 --out runs/shell
#   sbatch python/learners/slurm.sh evaluate --policy oracle --out results
#
# Arguments after the first word go to ppo_recurrent.py or to engram eval. Change the resources to
# those of your cluster, here or on the command line of sbatch.
#SBATCH --job-name=engram
#SBATCH --nodes=4
#SBATCH --ntasks-per-node=1
#SBATCH --cpus-per-task=32
#SBATCH --time=02:00:00
set -euo pipefail
export OMP_NUM_THREADS=1 # processes and engram's own threads use all cores already

# A torchrun on each node starts a learner for each core; gloo averages their gradients. Where nodes
# have several networks, GLOO_SOCKET_IFNAME=ib0 chooses one.
learn() {
  local first
  first=$(scontrol show hostnames "$SLURM_JOB_NODELIST" | head -n 1)
  srun --kill-on-bad-exit=1 torchrun \
    --nnodes "$SLURM_JOB_NUM_NODES" --nproc-per-node "$SLURM_CPUS_PER_TASK" \
    --rdzv-backend c10d --rdzv-endpoint "$first:29500" --rdzv-id "$SLURM_JOB_ID" \
    -m engram_learners.ppo_recurrent \
    --envs $((8 * SLURM_CPUS_PER_TASK * SLURM_JOB_NUM_NODES)) "$@"
}

# All ids. The nodes' processes communicate by MPI. If srun cannot start those (srun --mpi=list),
# replace srun and its options by `mpirun --map-by node`. --resume continues an interrupted run.
evaluate() {
  srun --mpi=pmix --kill-on-bad-exit=1 \
    engram eval --all --threads "$SLURM_CPUS_PER_TASK" "$@"
}

case "${1-}" in
learn | evaluate) "$@" ;;
*)
  echo "slurm.sh: '${1-}' given, 'learn' or 'evaluate' allowed" >&2
  exit 2
  ;;
esac
