#!/bin/sh
# Makes a virtual environment with this package in it, unless it is there already.
#   make_env.sh FOLDER EXTRAS "FITTING VERSIONS" [PYTHON]
# It is made anew when pyproject.toml, the Python, the extras or the folder's place change.
set -eu
folder=$1 extras=$2 fitting=$3 python=${4-}
stamp=$folder/.photon_map

fail() {
    echo "photon map: $1" >&2
    exit 1
}

version_of() {
    "$1" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null
}

# A name as it runs here: itself, or the newest of pyenv's Pythons that has it, because
# pyenv shows only those that were chosen with `pyenv global`.
runnable() {
    if [ -z "$(version_of "$1")" ] && command -v pyenv >/dev/null; then
        version=$(pyenv whence "$1" 2>/dev/null | tail -n 1)
        [ -z "$version" ] || { echo "$(pyenv prefix "$version")/bin/$1" && return; }
    fi
    echo "$1"
}

fits() {
    case " $fitting " in *" $1 "*) ;; *) return 1 ;; esac
}

wanted=$(echo "$fitting" | sed 's/ /, /g; s/\(.*\), /\1 or /')
remedy="choose one with: make PYTHON=python3.13 render (a name or a path)"
if [ -n "$python" ]; then
    python=$(runnable "$python")
    version=$(version_of "$python") || fail "'$python' does not run as a Python; $remedy"
    fits "$version" || fail "'$python' is Python $version, this needs $wanted; $remedy"
else
    seen=
    for version in $fitting ''; do
        name=$(runnable "python3${version#3}")
        found=$(version_of "$name") || continue
        if fits "$found"; then
            python=$name
            break
        fi
        seen="python3 is Python $found; "
    done
    [ -n "$seen" ] || seen="on Debian: apt-get install python3 python3-venv; "
    [ -n "$python" ] || fail "no Python $wanted was found; $seen$remedy"
    version=$found
fi
"$python" -c 'import ensurepip, venv' 2>/dev/null ||
    fail "'$python' has no venv module; on Debian: apt-get install python$version-venv"

key="$("$python" -c 'import sys; print(sys.executable, sys.version.split()[0])')
$extras
$(cksum <pyproject.toml)
$(pwd)"
[ -f "$stamp" ] && [ "$(cat "$stamp")" = "$key" ] && exit 0

echo "Making $folder with Python $version: $extras"
"$python" -m venv --clear "$folder"
"$folder/bin/python" -m pip install --quiet --disable-pip-version-check --editable ".[$extras]"
printf '%s\n' "$key" >"$stamp"
