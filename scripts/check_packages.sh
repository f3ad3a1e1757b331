#!/usr/bin/env bash
# Installs the packages of scripts/package.sh with apt on a bare Debian 12, and builds and runs
# another project's programs there: check_packages.sh [FOLDER], which holds the clean root afterwards
# (default: a temporary one, removed at the end). Needs root, debootstrap and a Debian mirror.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

mirror=$(scripts/install_dependencies.sh --mirror)
if [ "$(id -u)" -ne 0 ]; then
  echo "check_packages.sh needs root for chroot" >&2
  exit 1
fi
if ! command -v debootstrap >/dev/null; then
  apt-get -y install --no-install-recommends debootstrap >&2
fi

root=${1:-}
if [ -z "$root" ]; then
  root=$(mktemp -d)
  trap 'rm -rf "$root"' EXIT
fi
if [ ! -e "$root/bin/sh" ]; then
  debootstrap --variant=minbase bookworm "$root" "$mirror" >&2
fi

inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive "$@"; }
mkdir -p "$root/packages"
rm -f "$root"/packages/*.deb
cp "${BUILD_DIR:-build/package}"/packages/*.deb "$root/packages"
cmake -DPAGE=docs/embedding.md -DPROJECT=tests/packaging/project -DFOLDER="$root/outside" \
  -P tests/packaging/page_project.cmake
cmake -DPAGE=docs/cpp_tasks.md -DFOLDER="$root/outside/tasks" -P tests/packaging/page_tasks.cmake
inside apt-get update -q

echo "== the library and the command alone"
inside sh -c 'apt-get install -y -q --no-install-recommends /packages/libengram0_*.deb /packages/engram_*.deb'
inside engram rollout RememberColor3-VLA-v0 --num-envs 16 --steps 25 --policy oracle

echo "== another project's programs, through CMake and through pkg-config"
inside sh -c 'apt-get install -y -q --no-install-recommends /packages/libengram-dev_*.deb cmake make gcc g++ libc6-dev pkg-config'
inside sh -ec '
  cmake -S /outside -B /outside/build
  cmake --build /outside/build
  /outside/build/outside_c
  /outside/build/outside_cpp
  gcc -std=c11 -Wall -Wextra -Wpedantic -Werror /outside/outside.c -o /outside/plain_c $(pkg-config --cflags --libs engram)
  g++ -std=c++20 -Wall -Wextra -Wpedantic -Werror /outside/outside.cc -o /outside/plain_cpp $(pkg-config --cflags --libs engram)
  /outside/plain_c
  /outside/plain_cpp'
echo "== another project's task, as a library"
inside sh -c 'apt-get install -y -q --no-install-recommends libeigen3-dev libtinyxml2-dev'
inside sh -ec '
  cmake -S /outside/tasks -B /outside/tasks/build
  cmake --build /outside/tasks/build
  /outside/build/outside_tasks /outside/tasks/build/libtouch_spot.so TouchSpot-VLA-v0
  engram --tasks /outside/tasks/build/libtouch_spot.so eval TouchSpot-VLA-v0 --policy oracle --episodes 32 --out /outside/results'
inside dpkg-query -W -f '${Package} ${Version}: ${Depends}\n' libengram0 libengram-dev engram

echo "== Python, with Gymnasium from its own registry"
cp /etc/ssl/certs/ca-certificates.crt "$root/outside/certificates.crt"  # those that this machine trusts
inside sh -c 'apt-get install -y -q --no-install-recommends /packages/python3-engram_*.deb python3-venv ca-certificates'
inside sh -ec '
  python3 -m venv --system-site-packages /outside/env
  /outside/env/bin/pip install -q --cert /outside/certificates.crt gymnasium
  /outside/env/bin/python -c "
import engram
env = engram.make_vec(\"RememberColor3-VLA-v0\", num_envs=16)
env.reset()
for _ in range(24):
    env.step(env.act(\"oracle\"))
print(\"Python:\", env.num_envs, \"environments stepped\")
env.close()
engram.load_tasks(\"/outside/tasks/build/libtouch_spot.so\")
env = engram.make_vec(\"TouchSpot-VLA-v0\", num_envs=16)
env.reset()
env.step(env.act(\"oracle\"))
env.close()"'

echo "== removal leaves nothing"
inside apt-get purge -y -q libengram0 libengram-dev engram python3-engram
if inside sh -c 'find / -xdev -path /packages -prune -o -path /outside -prune -o -path /proc -prune -o -name "*engram*" -print | grep .'; then
  echo "files of engram are left" >&2
  exit 1
fi
echo "packages are good"
