#!/bin/sh
# Compiles through ccache: ccache.sh PROGRAM COMPILER ARGUMENT...
# GCC would read the former precompiled header in place of the headers, so that ccache would take
# what another change made of it for this one. And it would keep the headers' former comments, by
# which GCC no longer knows a header again: depend mode counts comments.
previous=
for argument; do
  case $previous$argument in
    -o*.gch)
      rm -f "$argument"
      export CCACHE_DEPEND=1
      ;;
  esac
  previous=$argument
done
exec "$@"
