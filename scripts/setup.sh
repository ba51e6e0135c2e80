# What the scripts share; to be sourced. The only list of Debian packages, and the only place that makes .venv.
# shellcheck shell=bash

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
# What was compiled in one build folder is found again for the next one: paths are told from here.
export CCACHE_BASEDIR=$root

build_packages=(cmake ninja-build g++ libfmt-dev libcli11-dev libtomlplusplus-dev libhdf5-dev libeigen3-dev libsuitesparse-dev
  libopenblas-dev python3 python3-venv)
python_packages=(python3-dev)
# PETSc, and MPI under it, for -DMATPOINT_MPI=ON.
mpi_packages=(libopenmpi-dev openmpi-bin libpetsc-real-dev libhdf5-openmpi-dev pkg-config)
# ccache: the wheel compiles the same sources once more. libegl1, libgl1: PyVista draws by them, and crashes without.
test_packages=(libgtest-dev libgmock-dev ccache libegl1 libgl1)

say() { printf '\n== %s\n' "$*"; }
die() { printf 'error: %s\n' "$*" >&2; exit 1; }

# Those of the given Debian packages that are not installed.
missing_packages() {
  local package
  for package in "$@"; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)" = installed ] || echo "$package"
  done
}

# Installs Debian packages, as root or through sudo; does nothing when all are there.
install_packages() {
  if ! command -v apt-get >/dev/null; then
    echo "This is no Debian or Ubuntu: please install yourself what these packages hold: $*"
    return
  fi
  local missing
  mapfile -t missing < <(missing_packages "$@")
  [ ${#missing[@]} -gt 0 ] || return 0
  say "installing ${missing[*]}"
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || die "installing needs root or sudo; as root: apt-get install ${missing[*]}"
    as_root=(sudo)
  fi
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -q
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}"
}

# Makes .venv with the packages of a requirements file; a stamp in it says that they are there.
make_venv() {
  local requirements=$1
  local stamp=.venv/.installed-$(basename "$requirements" .txt)
  if [ ! -f "$stamp" ] || [ "$stamp" -ot "$requirements" ] || [ "$stamp" -ot python/requirements.txt ] || ! .venv/bin/python -c '' 2>/dev/null; then
    say "Python packages of $requirements into .venv"
    # An interrupted or moved .venv cannot be mended.
    .venv/bin/python -m pip --version >/dev/null 2>&1 || rm -rf .venv
    [ -d .venv ] || python3 -m venv .venv
    .venv/bin/python -m pip install -q --disable-pip-version-check -r "$requirements"
    touch "$stamp"
  fi
}

# Configures a preset; further arguments go to CMake.
configure() {
  local preset=$1
  shift
  # A build folder that came from elsewhere holds the paths of elsewhere.
  if [ -f "build/$preset/CMakeCache.txt" ] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "build/$preset/CMakeCache.txt"; then
    rm -rf "build/$preset"
  fi
  cmake --preset "$preset" -DMATPOINT_PYTHON="$root/.venv/bin/python" "$@"
}
