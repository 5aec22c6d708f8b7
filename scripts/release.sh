#!/usr/bin/env bash
# Makes a release: checks, the version everywhere, changelog, tag, source archive, packages, site.
#
#   scripts/release.sh VERSION              0.2.0: commits, tags v0.2.0 and writes build/release
#   scripts/release.sh VERSION --dry-run    the same in a copy, without tests, interfaces, packages and site; nothing changes here
#   scripts/release.sh --check              is the version the same everywhere?
#
# Refused: a tree with changes; a version that is not above the last tag; an empty section [Unreleased] of CHANGELOG.md;
# failed tests (tests/run.sh is run unless it has passed on this very commit); a patch version (0.y.Z) whose libraries have
# lost a part of the last tag's interface (docs/stability.md). Nothing is pushed.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
source scripts/common.sh

fail() {
  echo "release.sh: $1" >&2
  exit 1
}

# Where the version stands: file, and the expression that finds it.
versions() {
  local file expression
  while IFS=$'\t' read -r file expression; do
    printf '%s\t%s\n' "$file" "$(sed -nE "s/$expression/\\2/p" "$file" | head -n 1)"
  done <<'PLACES'
CMakeLists.txt	^(project\(procam VERSION )([0-9.]+)( .*)$
package.xml	^(.*<version>)([0-9.]+)(<\/version>.*)$
CITATION.cff	^(version: )([0-9.]+)()$
debian/changelog	^(procam \()([0-9.]+)(\) .*)$
PLACES
}

check_versions() {
  local file version first="" status=0
  while IFS=$'\t' read -r file version; do
    echo "$file: ${version:-none}"
    first=${first:-$version}
    [[ -n $version && $version == "$first" ]] || status=1
  done < <(versions)
  ((status == 0)) || echo "release.sh: the versions differ" >&2
  return "$status"
}

# Below: in the folder of the release, which is a copy in a dry run.

set_version() {
  sed -i -E "s/^(project\(procam VERSION )[0-9.]+/\1$version/" CMakeLists.txt
  sed -i -E "s/(<version>)[0-9.]+(<\/version>)/\1$version\2/" package.xml
  sed -i -E "s/^version: [0-9.]+$/version: $version/; /^date-released: /d" CITATION.cff
  sed -i -E "/^version: /a date-released: $day" CITATION.cff
  if [[ $(sed -nE '1s/^procam \(([0-9.]+)\).*/\1/p' debian/changelog) != "$version" ]]; then
    { printf 'procam (%s) unstable; urgency=medium\n\n  * See CHANGELOG.md.\n\n -- procam maintainers <maintainers@procam.example>  %s\n\n' \
        "$version" "$(LC_ALL=C date -u -R -d "$day")"
      cat debian/changelog; } >debian/changelog.new
    mv debian/changelog.new debian/changelog
  fi
  sed -i "s/^## \[Unreleased\]$/## [Unreleased]\n\n## [$version] - $day/" CHANGELOG.md
}

# The source archive: the same bytes whenever and wherever it is made from the tag.
archive() {
  git -c tar.umask=0022 archive --format=tar --prefix="procam-$version/" "v$version" | gzip -n -9 >"$1"
}

commit_and_tag() {
  git add CMakeLists.txt package.xml CITATION.cff debian/changelog CHANGELOG.md || return 1
  git commit -q -m "procam $version" || return 1
  git tag -a "v$version" -m "procam $version"
}

write_archive() {
  mkdir -p "$out" && archive "$out/procam-$version.tar.gz" && archive "$out/again.tar.gz" || return 1
  cmp "$out/procam-$version.tar.gz" "$out/again.tar.gz" && rm "$out/again.tar.gz" || return 1
  (cd "$out" && sha256sum "procam-$version.tar.gz" | tee "procam-$version.tar.gz.sha256")
}

shared_libraries() {  # COMMIT FOLDER: builds its libraries, with types for abidiff
  rm -rf "$2" && mkdir -p "$2"/source || return 1
  git archive "$1" | tar -x -C "$2"/source || return 1
  cmake -S "$2"/source -B "$2"/build -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DBUILD_SHARED_LIBS=ON -DCMAKE_UNITY_BUILD=ON \
    -DPROCAM_BUILD_TESTS=OFF -DPROCAM_BUILD_EXAMPLES=OFF -DPROCAM_BUILD_TOOLS=OFF >/dev/null || return 1
  cmake --build "$2"/build && mkdir "$2"/libraries || return 1
  find "$2"/build -name 'libprocam_*.so' -exec cp -L {} "$2"/libraries \;
}

compare_interfaces() {
  if [[ -z $last ]]; then
    echo "no tag yet: nothing to compare with"
    return 0
  fi
  shared_libraries "$last" "$out"/abi/before && shared_libraries HEAD "$out"/abi/after || return 1
  local status=0
  scripts/abi.sh "$out"/abi/before/libraries "$out"/abi/after/libraries >"$out"/abi.txt || status=$?
  tail -n 1 "$out"/abi.txt
  ((status < 2)) || return 1
  if ((status)) && [[ ${version%.*} == "${last_version%.*}" ]]; then
    cat "$out"/abi.txt
    echo "a patch version keeps the interface (docs/stability.md): restore it, or make this ${version%.*.*}.$((${minor} + 1)).0"
    return 1
  fi
}

if [[ ${1:-} == --check ]]; then
  check_versions
  exit
fi
version=${1:-} dry=false
case ${2:-} in
  --dry-run) dry=true ;;
  "") ;;
  *) version="" ;;
esac
[[ $version =~ ^[0-9]+\.([0-9]+)\.[0-9]+$ ]] || { sed -n '2,10s/^# \?//p' "$0" >&2 && exit 2; }
minor=${BASH_REMATCH[1]}
day=$(date -u -d "@${SOURCE_DATE_EPOCH:-$(date +%s)}" +%F)

[[ -z $(git status --porcelain) ]] || { git status --short >&2 && fail "the tree has changes: commit or remove them"; }
last=$(git describe --tags --abbrev=0 --match 'v[0-9]*' 2>/dev/null || true)
last_version=${last#v}
if [[ -n $last ]]; then
  highest=$(printf '%s\n%s\n' "$last_version" "$version" | sort -V | tail -n 1)
  [[ $version != "$last_version" && $version == "$highest" ]] || fail "$version is not above the last tag, $last"
fi
check_versions || fail "make them equal first"
# Something to tell between [Unreleased] and the next version.
awk '/^## \[Unreleased\]/ { on = 1; next } /^## / { on = 0 } on && NF { found = 1 } END { exit !found }' CHANGELOG.md ||
  fail "CHANGELOG.md has nothing under [Unreleased]"

out=$root/build/release
if $dry; then
  copy=$(mktemp -d)
  trap 'rm -rf "$copy"' EXIT
  git clone -q "$root" "$copy"/procam && cd "$copy"/procam
  git config user.name "dry run" && git config user.email "dry-run@procam.example"
  out=$copy/release
  echo "a dry run: tests, interfaces, packages and site are omitted"
else
  passed=$(cat build/tests_passed 2>/dev/null || true)
  if [[ $passed == "$(git rev-parse 'HEAD^{tree}')" ]]; then
    echo "tests/run.sh has passed on this tree"
  else
    phase "tests" tests/run.sh || fail "the tests failed"
  fi
  install_packages "${build_packages[@]}" "${release_packages[@]}"
  mkdir -p "$out"
  phase "clang-tidy" scripts/tidy.sh --all || fail "clang-tidy"
  phase "interfaces" compare_interfaces || fail "the interfaces"
fi

set_version
check_versions || fail "the version could not be set everywhere"
phase "commit and tag" commit_and_tag
phase "source archive" write_archive
if $dry; then
  git show --stat --format='%s' HEAD
  echo "dry run: v$version would be made; nothing was changed"
  exit 0
fi
phase "packages" scripts/packages.sh
phase "site" scripts/site.sh
cp build/packages/*.deb "$out"
tar --sort=name --mtime="@$(git log -1 --format=%ct)" --owner=0 --group=0 --numeric-owner -C build/site -c html | gzip -n -9 >"$out/procam-$version-site.tar.gz"
scripts/site_versions.sh "$out"/site "$out"/procam-*-site.tar.gz
ls -lh "$out"
echo "v$version is made. To publish: git push origin HEAD v$version"
