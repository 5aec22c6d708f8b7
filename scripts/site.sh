#!/usr/bin/env bash
# Builds the site of the documents and the reference of C++ and Python into build/site/html, without network:
#
#   scripts/site.sh [--stubs FILE] [--no-packages]
#
# --stubs: __init__.pyi of the Python package; else that of the newest build with -DPROCAM_BUILD_PYTHON=ON, else Python's
# reference is omitted, with a note. --no-packages: do not look for missing Debian packages. Warnings of Sphinx are errors,
# and every link within the site is followed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/common.sh

stubs="" packages=true
while (($#)); do
  case $1 in
    --stubs) stubs=$2 && shift ;;
    --no-packages) packages=false ;;
    *) sed -n '2,9s/^# \?//p' "$0" >&2 && exit 2 ;;
  esac
  shift
done
out=$PWD/build/site
export PROCAM_SITE_EXTRA=$out/source/_extra
PROCAM_VERSION=$(sed -n 's/^project(procam VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
export PROCAM_VERSION
# What Sphinx writes must not depend on the time of day.
export SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || date +%s)}
export PYTHONDONTWRITEBYTECODE=1

read_headers() {
  rm -rf "$out"/doxygen "$out"/include && mkdir -p "$out" || return 1
  python3 docs/site/headers.py include "$out"/include || return 1
  local status=0
  (cat docs/site/Doxyfile && printf '%s\n' "INPUT = $out/include/procam" "STRIP_FROM_PATH = $out/include" "OUTPUT_DIRECTORY = $out/doxygen") |
    doxygen - >"$out"/doxygen.log 2>&1 || status=$?
  if ((status != 0)) || grep -q "warning:\|error:" "$out"/doxygen.log; then cat "$out"/doxygen.log && return 1; fi
}

write_pages() {
  if [[ -z $stubs ]]; then
    stubs=$(ls -t build/*/src/python/package/procam/__init__.pyi 2>/dev/null | head -n 1 || true)
  fi
  echo "Python's reference: ${stubs:-none, no build has the package}"
  python3 docs/site/pages.py "$PWD" "$out"/doxygen/xml "$out"/source ${stubs:+"$stubs"} || return 1
  rm -rf "$out"/html
  sphinx-build -q -W --keep-going -j auto -b html -d "$out"/doctrees -c docs/site "$out"/source "$out"/html
}

if $packages; then install_packages "${site_packages[@]}"; fi
phase "headers" read_headers
phase "pages" write_pages
phase "links" python3 docs/site/check_links.py "$out"/html
echo "build/site/html/index.html"
