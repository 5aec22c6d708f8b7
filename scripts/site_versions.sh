#!/usr/bin/env bash
# Joins the sites of several versions to one, with a menu of versions in every page:
#
#   scripts/site_versions.sh OUT procam-0.1.0-site.tar.gz procam-0.2.0-site.tar.gz ...
#
# The archives are those that scripts/release.sh leaves in build/release, so that no old version is built again. OUT gets a
# folder for each version, versions.js with their list, newest first, and index.html, which leads to the newest. OUT is written
# anew; every link is followed.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

(($# >= 2)) || { sed -n '2,8s/^# \?//p' "$0" >&2 && exit 2; }
out=$1 && shift
parent=$(cd "$(dirname "$out")" && pwd) || { echo "site_versions.sh: there is no folder to hold $out: make it first" >&2 && exit 1; }
joined=$(mktemp -d "$parent/site.XXXXXX")
trap 'rm -rf "$joined"' EXIT

versions=()
for archive in "$@"; do
  name=${archive##*/}
  if [[ ! $name =~ ^procam-([0-9]+(\.[0-9]+)*)-site\.tar\.gz$ ]]; then
    echo "site_versions.sh: $archive is not named procam-VERSION-site.tar.gz: give archives of scripts/release.sh" >&2
    exit 1
  fi
  version=${BASH_REMATCH[1]}
  if [[ -e $joined/$version ]]; then
    echo "site_versions.sh: version $version is given twice: give one archive of it" >&2
    exit 1
  fi
  mkdir "$joined/$version"
  if ! tar -xzf "$archive" -C "$joined/$version" --strip-components=1; then
    echo "site_versions.sh: $archive cannot be unpacked, it is missing or damaged: give an archive of scripts/release.sh" >&2
    exit 1
  fi
  if [[ ! -e $joined/$version/index.html ]]; then
    echo "site_versions.sh: $archive holds no index.html: give an archive of scripts/release.sh" >&2
    exit 1
  fi
  versions+=("$version")
done
mapfile -t versions < <(printf '%s\n' "${versions[@]}" | sort -rV)

printf 'window.procamVersions = [%s];\n' "$(printf '"%s", ' "${versions[@]}" | sed 's/, $//')" >"$joined"/versions.js
cat >"$joined"/index.html <<HTML
<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>procam</title>
<meta http-equiv="refresh" content="0; url=${versions[0]}/index.html"></head>
<body><a href="${versions[0]}/index.html">procam ${versions[0]}</a></body></html>
HTML
python3 "$here"/docs/site/check_links.py "$joined"
chmod 755 "$joined"
if [[ -e $out && ! -e $out/versions.js ]]; then
  echo "site_versions.sh: $out exists and is no joined site: remove it, or name another folder" >&2
  exit 1
fi
rm -rf "$out" && mv "$joined" "$out"
trap - EXIT
echo "$out/index.html: versions ${versions[*]}"
