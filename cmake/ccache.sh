#!/bin/sh
# Compiles through ccache: ccache.sh PROGRAM COMPILER ARGUMENT...
# GCC would read the former precompiled header in place of the headers, so that ccache would take
# what another change made of it for this one.
previous=
for argument; do
  case $previous$argument in -o*.gch) rm -f "$argument" ;; esac
  previous=$argument
done
exec "$@"
