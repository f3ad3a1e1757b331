#!/usr/bin/env bash
# Rolls tasks out on an emulated processor with AVX-512 (Bochs, Skylake-X) and compares hashes with
# this machine's: check_avx512.sh [ID...], default the last task of each family. For machines that
# have no AVX-512. Takes a few minutes for the start, and up to a minute for a task.
#   STEPS   control steps of a rollout, default 50
# Needs build/release and root, for packages.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/help.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

steps=${STEPS:-50}
engram=build/release/engram
scripts/install_dependencies.sh bochs bochs-x bochsbios vgabios xvfb xauth busybox-static cpio \
  xorriso isolinux syslinux-common
ids=("$@")
[ ${#ids[@]} -gt 0 ] || mapfile -t ids < <("$engram" list --json | python3 -c '
import json, sys
print(*{task["family"]: task["id"] for task in json.load(sys.stdin)}.values(), sep="\n")')

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
root=$work/root
mkdir -p "$root"/{bin,proc,sys,dev,tmp,lib64,lib/x86_64-linux-gnu} "$work/disc"

# What both run: a line for every rollout.
cat > "$root/rollouts" <<EOF
for id in ${ids[*]}; do
  for policy in oracle random; do
    for lanes in 0 1 4 8; do
      echo "\$id \$policy lanes \$lanes" \$("\$1" rollout \$id --policy \$policy --num-envs 16 \\
        --steps $steps --threads 1 --lanes \$lanes --hash --json 2>&1 |
        grep -o '"hash".*')
    done
  done
done
EOF
cat > "$root/init" <<'EOF'
#!/bin/sh
busybox mount -t proc none /proc
busybox mount -t sysfs none /sys
busybox mount -t devtmpfs none /dev
busybox mount -t tmpfs none /tmp
export LD_LIBRARY_PATH=/lib/x86_64-linux-gnu HOME=/tmp
exec > /dev/ttyS0 2>&1
busybox grep -qw avx512vl /proc/cpuinfo && echo "has AVX-512"
sh /rollouts /bin/engram
echo "all done"
busybox sleep 2  # until the serial line has sent it
busybox poweroff -f
EOF
chmod +x "$root/init"
cp /bin/busybox "$root/bin/"
for tool in sh grep; do ln -s busybox "$root/bin/$tool"; done
strip -o "$root/bin/engram" "$engram"
ldd "$engram" | grep -o ' /[^ ]*' | xargs cp -Lt "$root/lib/x86_64-linux-gnu"
cp -L /lib64/ld-linux-x86-64.so.2 "$root/lib64/"

kernel=$(apt-cache depends linux-image-amd64 |
  sed -n 's/.*Depends: \(linux-image-[0-9]\)/\1/p' | head -1)
(cd "$work" && apt-get download -q "$kernel" 2>/dev/null >&2 && dpkg -x "$kernel"_*.deb kernel)
cp "$work"/kernel/boot/vmlinuz-* "$work/disc/vmlinuz"
(cd "$root" && find . | cpio -o -H newc --quiet | gzip -1) > "$work/disc/initrd"
cp /usr/lib/ISOLINUX/isolinux.bin /usr/lib/syslinux/modules/bios/ldlinux.c32 "$work/disc/"
# Linux takes the sizes that Bochs gives for compacted states as wrong, and would use no AVX at all.
cat > "$work/disc/isolinux.cfg" <<'EOF'
DEFAULT linux
LABEL linux
 KERNEL vmlinuz
 INITRD initrd
 APPEND console=ttyS0 quiet clearcpuid=xsaves,xsavec mitigations=off lpj=1000000 random.trust_cpu=on
EOF
xorriso -as mkisofs -quiet -o "$work/disc.iso" -b isolinux.bin -c boot.cat -no-emul-boot \
  -boot-load-size 4 -boot-info-table "$work/disc" 2>/dev/null
cat > "$work/bochsrc" <<EOF
cpu: model=corei7_skylake_x, ips=100000000
memory: guest=2048, host=2048
romimage: file=/usr/share/bochs/BIOS-bochs-latest
vgaromimage: file=/usr/share/bochs/VGABIOS-lgpl-latest
ata0-master: type=cdrom, path=$work/disc.iso, status=inserted
boot: cdrom
com1: enabled=1, mode=file, dev=$work/serial
log: $work/log
display_library: x
clock: sync=none
sound: driver=dummy
EOF

sh "$root/rollouts" "$engram" > "$work/here"
# Debian's Bochs has its debugger, which waits for "continue".
(cd "$work" && echo c | xvfb-run -a bochs -q -f bochsrc > bochs.out 2>&1) || true
tr -d '\r' < "$work/serial" > "$work/there"
for sign in "has AVX-512" "all done"; do
  if ! grep -q "^$sign" "$work/there"; then
    echo "the emulated machine did not say \"$sign\"; its last lines:" >&2
    tail "$work/there" >&2
    exit 1
  fi
done
if grep ' lanes ' "$work/there" | diff "$work/here" - > "$work/different"; then
  echo "$(wc -l < "$work/here") rollouts of ${#ids[@]} tasks, 0 different"
else
  cat "$work/different"
  exit 1
fi
