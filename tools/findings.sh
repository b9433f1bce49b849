#!/usr/bin/env bash
# Runs the findings: surprises between outside tools, as findings/README.md describes. CI does not run them, because each
# installs packages in a temporary folder. All of them take 15 minutes or more.
#   ./tools/findings.sh            # all of them
#   ./tools/findings.sh NAME...    # findings/NAME.sh
# Prints what each shows, and a last line. Exits 1 if a behavior changed or a script could not run, and 2 for an unknown name.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts=()
for name in "$@"; do
    script=findings/$(basename "$name" .sh).sh
    [[ -f $script ]] || { echo "findings: there is no $script; ls findings lists the names" >&2; exit 2; }
    scripts+=("$script")
done
[[ $# -gt 0 ]] || scripts=(findings/*.sh)
changed=()
for script in "${scripts[@]}"; do
    name=$(basename "$script" .sh)
    echo "== $name"
    bash "$script" || changed+=("$name")
done
echo "findings: ${#scripts[@]} run, $((${#scripts[@]} - ${#changed[@]})) as stated, ${#changed[@]} not: ${changed[*]:-none}"
[[ ${#changed[@]} -eq 0 ]]
