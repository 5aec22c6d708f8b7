#!/usr/bin/env bash
# scripts/site_versions.sh with small sites:   site_versions.sh ROOT
set -euo pipefail
root=$1
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"

fail() {
  echo "FAILED: $1"
  cat said
  exit 1
}
refused() {  # WHY ARGUMENT...
  local why=$1
  shift
  if "$root"/scripts/site_versions.sh "$@" >said 2>&1; then fail "accepted: $*"; fi
  grep -q -- "$why" said || fail "it does not say: $why"
}
site() {  # VERSION LINK
  mkdir html && echo "<a href=\"$2\">version $1</a>" >html/index.html && tar -czf "procam-$1-site.tar.gz" html && rm -r html
}

site 0.9.0 index.html
site 0.10.0 ../0.9.0/index.html
site 0.2.0 nowhere.html
"$root"/scripts/site_versions.sh joined procam-0.9.0-site.tar.gz procam-0.10.0-site.tar.gz >said 2>&1 || fail "two versions"
[[ $(<joined/versions.js) == 'window.procamVersions = ["0.10.0", "0.9.0"];' ]] || fail "the list is $(<joined/versions.js)"
grep -q 'url=0.10.0/index.html' joined/index.html || fail "the first page leads elsewhere"
grep -q 'version 0.9.0' joined/0.9.0/index.html || fail "version 0.9.0 is missing"

# What was there stays where something is wrong.
refused "no file nowhere.html" joined procam-0.2.0-site.tar.gz
refused "is not named procam-VERSION-site.tar.gz" joined /dev/null
echo noise >procam-0.4.0-site.tar.gz
refused "missing or damaged" joined procam-0.4.0-site.tar.gz
refused "missing or damaged" joined procam-0.5.0-site.tar.gz
refused "given twice" joined procam-0.9.0-site.tar.gz ./procam-0.9.0-site.tar.gz
refused "no folder to hold" absent/joined procam-0.9.0-site.tar.gz
mkdir photographs
refused "is no joined site" photographs procam-0.9.0-site.tar.gz
mkdir other && tar -czf procam-0.3.0-site.tar.gz other
refused "holds no index.html" joined procam-0.3.0-site.tar.gz
[[ -e joined/0.9.0/index.html && -d photographs ]] || fail "a refusal removed a folder"
[[ $(find . -maxdepth 1 -name 'site.*' | wc -l) == 0 ]] || fail "temporary folders are left"

"$root"/scripts/site_versions.sh joined procam-0.9.0-site.tar.gz >said 2>&1 || fail "once more"
[[ ! -e joined/0.10.0 ]] || fail "an old version is left"
