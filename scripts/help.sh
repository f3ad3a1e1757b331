# shellcheck shell=bash
# Sourced by the scripts: --help prints the comment at the beginning of a script, and does nothing else.
case ${1:-} in
  --help | -h)
    sed -n '2,/^[^#]/ s/^# \{0,1\}//p' "$0"
    exit
    ;;
esac
