#!/usr/bin/env bash
# Runs its arguments with a Python 3 that has NumPy. The python3 first on PATH may be another than the one that the
# system's NumPy belongs to, hence the search. Fails when there is none: a check that cannot run must not look passed.
set -euo pipefail

for python in "${VOTESS_PYTHON:-}" /usr/bin/python3 python3; do
    if [[ -n $python ]] && "$python" -c 'import sys, numpy; sys.exit(sys.version_info < (3, 9))' 2>/dev/null; then
        exec "$python" "$@"
    fi
done
echo "no Python 3.9 or newer with NumPy: install it (Debian, Ubuntu: apt-get install python3-numpy)" \
     "or name one in VOTESS_PYTHON" >&2
exit 1
