#!/usr/bin/env bash
# scripts/release.sh in a small repository of the files that it reads:   dry_run.sh ROOT
set -euo pipefail
root=$1
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
unset GIT_DIR GIT_WORK_TREE GIT_INDEX_FILE

fail() {
  echo "FAILED: $1"
  cat "$scratch"/said
  exit 1
}
release() {
  scripts/release.sh "$@" >"$scratch"/said 2>&1
}
said() {
  grep -q -- "$1" "$scratch"/said || fail "it does not say: $1"
}
refused() {  # WHY ARGUMENT...
  local why=$1
  shift
  if release "$@"; then fail "accepted: $*"; fi
  said "$why"
}

mkdir "$scratch"/procam && cd "$scratch"/procam
mkdir scripts debian
cp "$root"/{CMakeLists.txt,package.xml,CITATION.cff,CHANGELOG.md} .
cp "$root"/scripts/{release.sh,common.sh,abi.sh} scripts
cp "$root"/debian/changelog debian
grep -q '^## \[Unreleased\]' CHANGELOG.md || sed -i '4i ## [Unreleased]' CHANGELOG.md
sed -i 's/^## \[Unreleased\]$/&\n\n- A change./' CHANGELOG.md
git init -q . && git config user.name test && git config user.email test@procam.example
git add . && git commit -q -m "as it is"
before=$(git rev-parse HEAD)

# Without a tag. The version is set everywhere, in the copy alone; the archive is the same when it is made again.
release 9.8.7 --dry-run || fail "a dry run"
said "CMakeLists.txt: 9.8.7"
said "package.xml: 9.8.7"
said "CITATION.cff: 9.8.7"
said "debian/changelog: 9.8.7"
said "procam-9.8.7.tar.gz"
said "v9.8.7 would be made"
[[ $(git rev-parse HEAD) == "$before" && -z $(git status --porcelain) && -z $(git tag) ]] || fail "the dry run changed the repository"

grep -qE '^[0-9a-f]{64}  procam-9.8.7.tar.gz$' "$scratch"/said || fail "no checksum of the archive"

refused "Makes a release" 9.8
refused "Makes a release" 9.8.7 --dry
git tag -a v9.8.7 -m before
refused "not above the last tag" 9.8.7 --dry-run
refused "not above the last tag" 9.8.6 --dry-run
release 9.10.0 --dry-run || fail "9.10.0 after 9.8.7"

echo change >>package.xml
refused "the tree has changes" 9.9.0 --dry-run
git checkout -q package.xml
sed -i 's/<version>[0-9.]*/<version>0.0.9/' package.xml && git commit -q -a -m "another version in one place"
refused "the versions differ" 9.9.0 --dry-run
refused "the versions differ" --check
git reset -q --hard "$before"
sed -i '/^## \[Unreleased\]/,$d' CHANGELOG.md && printf '## [Unreleased]\n\n## [0.0.1] - 2026-01-01\n\n- Old.\n' >>CHANGELOG.md
git commit -q -a -m "nothing to tell"
refused "nothing under \[Unreleased\]" 9.9.0 --dry-run
echo "passed"
