#!/usr/bin/env bash
# Installs what scripts/wheel.sh and scripts/package.sh have built on clean systems, plays there, and
# prints a table: check_install.sh [ROW...], default the wheels. Wheels are installed with pip where
# there is no compiler, and record, too.
#   debian:SUITE[:PYTHON]   a bare Debian (bookworm, trixie, sid), with its Python or one of its others
#   python:PREFIX           a Python that lies in a folder of this machine, moved into bare bookworm
#   aarch64                 the wheel for 64-bit ARM, on an emulated processor; after wheel.sh aarch64
#   sdist                   the sources, built by pip in a bookworm with nothing but what they need
#   older:SUITE             a Debian whose C library is too old (bullseye), where pip has to say no
#   packages                the Debian packages, on a bare bookworm; builds and runs the programs and
#                           the task library of another project there, and removes the packages
# What all wheels show has to be the same to the bit. Needs root, debootstrap and a Debian mirror.
# ROOTS names a folder that holds the clean roots afterwards.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

rows=("$@")
[ ${#rows[@]} -gt 0 ] || rows=(debian:bookworm debian:trixie debian:sid aarch64 sdist)
dist=$(realpath "${DIST:-build/dist}")
mirror=$(scripts/install_dependencies.sh --mirror)
most_seconds=10  # of the processor, for the first rollout
most_seconds_emulated=60
# Those of python/tests that take less than ten minutes together there.
emulated_tests=({env,vector_env,spaces,errors,options_refused,queries,objects,variants,gym_registration}.py
  tasks.py copies.py)
if [ "$(id -u)" -ne 0 ]; then
  echo "check_install.sh needs root for chroot" >&2
  exit 1
fi
scripts/install_dependencies.sh debootstrap
roots=${ROOTS:-$(mktemp -d)}
cleanup() {
  grep -F " $roots/" /proc/mounts | cut -d ' ' -f 2 | xargs -r umount
  [ -n "${ROOTS:-}" ] || rm -rf "$roots"
}
trap cleanup EXIT

fingerprints=()
enter=(chroot)

inside() {  # ROOT COMMAND...
  "${enter[@]}" "$1" env -i PATH=/env/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
    DEBIAN_FRONTEND=noninteractive PIP_CERT=/certificates.crt "${@:2}"
}

# A root of its own for each row, from one bare root for each suite.
new_root() {  # SUITE NAME -> $root
  local bare=$roots/bare-$1
  root=$roots/$2
  if [ ! -e "$bare/bin/sh" ]; then
    debootstrap --variant=minbase "$1" "$bare" "$mirror" >&2
  fi
  copy_root "$bare" "$root"
  # Unstable's lists have a last day, which a mirror may have passed.
  inside "$root" apt-get -o Acquire::Check-Valid-Until=false update -q >&2
}

copy_root() {  # BARE ROOT
  rm -rf --one-file-system "$2"
  cp -a "$1" "$2"
  mount -t proc proc "$2/proc"  # programs find their own libraries by it
  cp /etc/ssl/certs/ca-certificates.crt "$2/certificates.crt"  # those that this machine trusts
  cp -r tests/packaging "$2/packaging"
  [ ! -d "$dist" ] || cp -r "$dist" "$2/dist"
}

# Files, not names, are installed: pip would look for a name on its index, too.
newest() {  # PATTERN -> the name of the newest file of $dist
  local name
  name=$(find "$dist" -maxdepth 1 -name "$1" -printf '%T@ %f\n' | sort -n | tail -n 1 | cut -d ' ' -f 2-)
  if [ -z "$name" ]; then
    echo "check_install.sh: no $1 in $dist" >&2
    exit 1
  fi
  echo "$name"
}
newest_wheel() { newest "engram_sim-*manylinux*_$1.whl"; }  # MACHINE

seconds_of() {  # COMMAND... -> $seconds
  local begin=$EPOCHREALTIME
  "$@" >&2
  seconds=$(awk "BEGIN { printf \"%.1f\", $EPOCHREALTIME - $begin }")
}

note() {  # ROW PYTHON INSTALL-SECONDS INSTALLED-BYTES RESULT-OF-first_rollout.py
  local first busy fingerprint
  read -r first busy fingerprint <<<"$5"
  fingerprints+=("$fingerprint")
  echo "| $1 | $2 | $3 s | $(awk "BEGIN { printf \"%.1f\", $4 / 1e6 }") MB | $first s | \`$fingerprint\` |"
  if awk "BEGIN { exit !($busy > $most_seconds) }"; then
    echo "$1: the first rollout took $busy s of the processor, $most_seconds allowed" >&2
    exit 1
  fi
}

# What a user does, from the installation to a film.
try_out() {  # ROW ROOT PYTHON
  local row=$1 root=$2
  if inside "$root" sh -c 'command -v cc || command -v gcc || command -v clang'; then
    echo "$row: there is a compiler" >&2
    exit 1
  fi
  inside "$root" "$3" -m venv /env
  local version
  version=$(inside "$root" python -V)
  local wheel
  wheel=$(newest_wheel "$(inside "$root" uname -m)")
  seconds_of inside "$root" pip install -q --disable-pip-version-check "/dist/$wheel"
  local size result
  size=$(inside "$root" sh -c 'du -sbc /env/lib/python*/site-packages/engram* | tail -n 1 | cut -f 1')
  result=$(inside "$root" python /packaging/first_rollout.py)
  note "$row" "${version#Python }" "$seconds" "$size" "$result"
  inside "$root" sh -ec '
    test "$(engram list | grep -c VLA-v0)" -ge 97
    for command in list info rollout eval collect record play bench soak verify doctor; do
      engram $command --help >/dev/null
    done
    cd /tmp
    engram rollout RememberColor3-VLA-v0 --num-envs 16 --steps 25 --policy oracle
    engram collect RememberColor3-VLA-v0 --episodes 2 --out data >/dev/null
    engram record RememberColor3-VLA-v0 --overlays --at 1,5 --out sheet.png
    if engram record RememberColor3-VLA-v0 --out film.mp4 2>message; then exit 1; fi
    grep -F "pip install av" message
    pip install -q --disable-pip-version-check "/dist/$1[video]"
    for film in film.mp4 film.gif; do engram record RememberColor3-VLA-v0 --seed 1 --out $film; done
    python /packaging/check_film.py "$(python -m engram info RememberColor3-VLA-v0 --json |
      python -c "import json, sys; print(json.load(sys.stdin)[\"horizon\"] + 1)")" film.mp4 film.gif' sh "$wheel" >&2
}

try_debian() {  # ROW SUITE [PYTHON]
  local python=${3:-python3} root
  new_root "$2" "$2-$python"
  inside "$root" apt-get install -y -q --no-install-recommends "$python" "$python-venv" >&2
  try_out "$1" "$root" "$python"
}

# With the libraries that such a Python is usually linked to.
try_python() {  # ROW PREFIX
  local root
  new_root bookworm "python-${2##*/}"
  mkdir -p "$root${2%/*}"
  cp -a "$2" "$root${2%/*}"
  inside "$root" apt-get install -y -q --no-install-recommends libssl3 libffi8 libsqlite3-0 \
    zlib1g libbz2-1.0 liblzma5 libreadline8 libncursesw6 libuuid1 >&2
  try_out "$1" "$root" "$2/bin/python3"
}

# A bare Debian 12 for 64-bit ARM, unpacked and not configured: nothing of it has to run for that. In a
# namespace of its own the kernel (6.7 or newer) starts ARM's programs by QEMU, elsewhere it does not.
try_aarch64() {
  scripts/install_dependencies.sh qemu-user-static mmdebstrap
  local bare=$roots/bare-bookworm-arm64 root=$roots/bookworm-arm64
  if [ ! -e "$bare/bin/sh" ]; then
    mmdebstrap --variant=extract --architectures=arm64 --include="?essential" --include=apt,python3-venv \
      bookworm "$bare.new" "$mirror" >&2
    [ -e "$bare.new/bin/sh" ] || ln -s dash "$bare.new/bin/sh"
    mv "$bare.new" "$bare"
  fi
  copy_root "$bare" "$root"
  mkdir "$root/python" "$root/tests"
  cp -r python/tests "$root/python/tests"
  cp -r tests/data "$root/tests/data"
  local enter=(unshare --map-root-user --mount sh -ec "
    mount -t binfmt_misc none /proc/sys/fs/binfmt_misc
    cat /usr/lib/binfmt.d/qemu-aarch64.conf >/proc/sys/fs/binfmt_misc/register
    exec chroot \"\$@\"" sh)
  local most_seconds=$most_seconds_emulated
  try_out aarch64 "$root" python3
  inside "$root" pip install -q --disable-pip-version-check pytest >&2
  inside "$root" python -m pytest -q -p no:cacheprovider \
    "${emulated_tests[@]/#//python/tests/test_}" >&2
}

# A C library older than the wheel asks for: pip refuses the wheel and installs nothing.
try_older() {  # ROW SUITE
  local root name message own
  new_root "$2" "$2-older"
  inside "$root" apt-get install -y -q --no-install-recommends python3-venv >&2
  inside "$root" python3 -m venv /env
  name=$(newest_wheel "$(uname -m)")
  # That the suite's Python is too old, too, is not to be the reason.
  local fetch=(pip download -q --no-index --no-deps --only-binary ":all:" --python-version 3.11 -d /got)
  if message=$(inside "$root" "${fetch[@]}" "/dist/$name" 2>&1); then
    echo "$1: pip takes $name" >&2
    exit 1
  fi
  grep -F "$name is not a supported wheel on this platform" <<<"$message" >&2
  # Nor anything else but the system's age: with a tag that its own C library fits, pip takes the file.
  own=$(inside "$root" python -c 'import os; print(os.confstr("CS_GNU_LIBC_VERSION").split()[1])')
  own=$(sed -E "s/manylinux_[0-9]+_[0-9]+/manylinux_${own/./_}/" <<<"$name")
  cp "$dist/$name" "$root/dist/$own"
  inside "$root" "${fetch[@]}" "/dist/$own" >&2
  echo "| $1 | | refused | | | |"
}

try_sdist() {
  local root packages
  new_root bookworm sdist
  packages=$(scripts/install_dependencies.sh --list-libraries)
  # shellcheck disable=SC2086
  inside "$root" apt-get install -y -q --no-install-recommends $packages g++ pkg-config \
    fonts-dejavu-core python3-venv >&2
  inside "$root" python3 -m venv /env
  local sources
  sources=$(newest "engram_sim-*.tar.gz")
  seconds_of inside "$root" pip install -q --disable-pip-version-check "/dist/$sources"
  note sdist "$(inside "$root" python -c 'import platform; print(platform.python_version())')" \
    "$seconds" "$(inside "$root" sh -c 'du -sbc /env/lib/python*/site-packages/engram* | tail -n 1 | cut -f 1')" \
    "$(inside "$root" python /packaging/first_rollout.py)"
}

try_packages() {
  local root left
  new_root bookworm packages
  mkdir -p "$root/packages"
  cp "${BUILD_DIR:-build/package}"/packages/*.deb "$root/packages"
  cmake -DPAGE=docs/embedding.md -DPROJECT=tests/packaging/project -DFOLDER="$root/outside" \
    -P tests/packaging/page_project.cmake
  cmake -DPAGE=docs/cpp_tasks.md -DFOLDER="$root/outside/tasks" -P tests/packaging/page_tasks.cmake
  add() { inside "$root" sh -c "apt-get install -y -q --no-install-recommends $*"; }

  add '/packages/libengram0_*.deb' '/packages/engram_*.deb'  # alone
  inside "$root" engram rollout RememberColor3-VLA-v0 --num-envs 16 --steps 25 --policy oracle
  add '/packages/libengram-dev_*.deb' cmake make gcc g++ libc6-dev pkg-config libeigen3-dev libtinyxml2-dev
  inside "$root" sh -ec '
    cmake -S /outside -B /outside/build
    cmake --build /outside/build
    /outside/build/outside_c
    /outside/build/outside_cpp
    gcc -std=c11 -Wall -Wextra -Wpedantic -Werror /outside/outside.c -o /outside/plain_c $(pkg-config --cflags --libs engram)
    g++ -std=c++20 -Wall -Wextra -Wpedantic -Werror /outside/outside.cc -o /outside/plain_cpp $(pkg-config --cflags --libs engram)
    /outside/plain_c
    /outside/plain_cpp
    cmake -S /outside/tasks -B /outside/tasks/build
    cmake --build /outside/tasks/build
    /outside/build/outside_tasks /outside/tasks/build/libtouch_spot.so TouchSpot-VLA-v0
    engram --tasks /outside/tasks/build/libtouch_spot.so eval TouchSpot-VLA-v0 --policy oracle --episodes 32 --out /outside/results
    dpkg-query -W -f "\${Package} \${Version}: \${Depends}\n" libengram0 libengram-dev engram'
  add '/packages/python3-engram_*.deb' python3-venv ca-certificates
  inside "$root" sh -ec '
    python3 -m venv --system-site-packages /env
    pip install -q gymnasium
    python /packaging/outside.py'
  inside "$root" apt-get purge -y -q libengram0 libengram-dev engram python3-engram
  left=$(inside "$root" find / -xdev \( -path /packages -o -path /packaging -o -path /dist -o -path /outside \
    -o -path /env -o -path /proc \) -prune -o -name '*engram*' -print)
  if [ -n "$left" ]; then
    printf 'files of engram are left:\n%s\n' "$left"
    exit 1
  fi
}

echo "| where | Python | pip install | installed | first rollout | bits |"
echo "| --- | --- | ---: | ---: | ---: | --- |"
for row in "${rows[@]}"; do
  echo "== $row" >&2
  case $row in
    debian:*)
      IFS=: read -r _ suite python <<<"$row"
      try_debian "$row" "$suite" "$python"
      ;;
    python:*) try_python "$row" "${row#python:}" ;;
    aarch64) try_aarch64 ;;
    sdist) try_sdist ;;
    older:*) try_older "$row" "${row#older:}" ;;
    packages)
      try_packages >&2
      echo "| packages | | installed, removed | | | |"
      ;;
    *)
      echo "check_install.sh: '$row' given; debian:SUITE[:PYTHON], python:PREFIX, aarch64, sdist," \
        "older:SUITE and packages allowed" >&2
      exit 2
      ;;
  esac
done

if [ "$(printf '%s\n' "${fingerprints[@]}" | sort -u | wc -l)" -gt 1 ]; then
  echo "rows show different bits" >&2
  exit 1
fi
echo "all of them work"
