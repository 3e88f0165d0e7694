# Sourced by the bash scripts: where the project is, what a machine needs, how MPI is started.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)

packages=(g++ cmake make ninja-build pkgconf
  libopenmpi-dev openmpi-bin libpetsc-real-dev libmetis-dev libhdf5-openmpi-dev libeigen3-dev libyaml-cpp-dev
  libpugixml-dev libmuparser-dev libassimp-dev zlib1g-dev)
pieces_packages=(libbullet-extras-dev)
tool_packages=(ccache clang-format clang-tidy "${pieces_packages[@]}" libgtest-dev libmujoco-dev libfclib0 libxdmf-dev libxml2-dev
  procps python3 python3-numpy python3-h5py python3-matplotlib python3-jsonschema python3-yaml python3-vtk9 xvfb)
python_packages=(python3-dev pybind11-dev python3-numpy python3-mpi4py python3-pytest)
slurm_packages=(slurmctld slurmd slurm-client munge)
docs_packages=(mkdocs doxygen)
bench_packages=(libbullet-dev libode-dev libdart-dev libdart-collision-bullet-dev libdart-external-ikfast-dev liggghts lammps yade python3-siconos)

# How many processes may compute here at a time; nproc alone would tell the threads that OpenMP may have.
cores_here() { env -u OMP_NUM_THREADS -u OMP_THREAD_LIMIT nproc; }

# Tells each line of its input that is another one than before: on a terminal in place of the one before, else of those that end
# in '%' each tenth percent.
progress() {
  local line last='' number
  while IFS= read -r line; do
    number=${line//[!0-9]/}
    if [[ $line == "$last" ]]; then continue; fi
    if [[ -t 2 ]]; then
      printf '\r%s: %s\e[K' "$(basename "$0")" "$line" >&2
    elif [[ $line != *%* || $((10#${number:-0} % 10)) == 0 ]]; then
      say "$line"
    fi
    last=$line
  done
  if [[ -t 2 && -n $last ]]; then echo >&2; fi
}

say() { echo "$(basename "$0"): $*" >&2; }
die() { say "${@:2}"; exit "$1"; }

# Sets what `mpirun -n $1` needs here, all by environment: root, containers, more ranks than cores. On a cluster with its
# own launcher none of it matters.
mpi_environment() {
  local ranks=$1 cores threads
  threads=$(cores_here)
  cores=$(lscpu -p=CORE,SOCKET 2>/dev/null | grep -v '^#' | sort -u | wc -l)
  if ((cores < 1 || cores > threads)); then cores=$threads; fi
  if ((EUID == 0)); then export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1; fi
  if [[ -e /.dockerenv || -e /run/.containerenv ]]; then export OMPI_MCA_btl_vader_single_copy_mechanism=none; fi
  if ((ranks > cores)); then export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_hwloc_base_binding_policy=none; fi
  if ((ranks > threads)); then export OMPI_MCA_mpi_yield_when_idle=1; fi
  export OMPI_MCA_orte_execute_quiet=1  # the program has said what is wrong
  export OMP_NUM_THREADS=${OMP_NUM_THREADS:-1}
}
