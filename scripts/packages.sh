#!/usr/bin/env bash
# Builds the Debian packages and tries them:
#
#   scripts/packages.sh            packages in build/packages; lintian looks at them
#   scripts/packages.sh --reproducible
#                                  and builds them again, in another folder, with another time zone, language and umask: the
#                                  packages must be the same, byte for byte
#   scripts/packages.sh --bare     and installs them in a bare Debian 12 (debootstrap; needs root) that has nothing of
#                                  procam, and runs debian/tests there; the captures are the real ones of PROCAM_TEST_DATA
#                                  (../shared/data), where they are
#
# DEB_BUILD_OPTIONS=parallel=N as for dpkg-buildpackage. Ends with an error if lintian finds an error or a warning, or a test
# fails.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/common.sh

bare=false reproducible=false
for option in "$@"; do
  case $option in
    --bare) bare=true ;;
    --reproducible) reproducible=true ;;
    *) sed -n '2,14s/^# \?//p' "$0" >&2 && exit 2 ;;
  esac
done
out=$PWD/build/packages
commit=$(git rev-parse HEAD)

# The sources as they are committed, so that nothing of this folder gets into a package by chance.
build_packages_of_commit() {
  rm -rf "$out" && mkdir -p "$out"/procam || return 1
  git archive "$commit" | tar -x -C "$out"/procam || return 1
  (cd "$out"/procam && DEB_BUILD_OPTIONS=${DEB_BUILD_OPTIONS:-parallel=$(nproc)} dpkg-buildpackage -b -us -uc) >"$out"/build.log 2>&1 ||
    { tail -n 40 "$out"/build.log && return 1; }
  ls -lh "$out"/*.deb
}

# What differs between two packages of one name: files by their sums, and the control files.
show_difference() {
  local side
  for side in "$1" "$2"; do
    local folder
    folder=$(mktemp -d) && dpkg-deb -R "$side" "$folder" || return 1
    (cd "$folder" && find . -type f -exec sha256sum {} + | sort -k 2 && find . -printf '%m %y %p\n' | sort -k 3)
    rm -rf "$folder"
  done | sort | uniq -u | head -n 40
}

build_again_and_compare() {
  local again status=0 deb
  again=$(mktemp -d)/another/folder || return 1
  mkdir -p "$again"/procam || return 1
  git archive "$commit" | tar -x -C "$again"/procam || return 1
  (cd "$again"/procam && umask 027 && TZ=Pacific/Kiritimati LC_ALL=C.UTF-8 LANGUAGE=de HOME=/nonexistent \
    DEB_BUILD_OPTIONS=${DEB_BUILD_OPTIONS:-parallel=$(nproc)} dpkg-buildpackage -b -us -uc) >"$out"/build_again.log 2>&1 ||
    { tail -n 40 "$out"/build_again.log && return 1; }
  for deb in "$out"/*.deb; do
    if cmp -s "$deb" "$again/${deb##*/}"; then
      echo "${deb##*/}: the same"
    else
      echo "${deb##*/}: DIFFERS"
      show_difference "$deb" "$again/${deb##*/}"
      status=1
    fi
  done
  rm -rf "${again%/another/folder}"
  return "$status"
}

look_by_lintian() {
  lintian --fail-on error,warning "$out"/*.changes
}

# Runs debian/tests in a fresh system, as autopkgtest does: packages by apt, tests by their Depends.
try_in_bare_system() {
  local system test depends status=0
  system=$(mktemp -d) || return 1
  # Also taken back, as it would run again when the caller returns.
  trap 'remove_bare_system "$system"; trap - RETURN' RETURN
  make_bare_system "$system" || return 1
  local captures=${PROCAM_TEST_DATA:-../shared/data}/graycode
  if [[ -d $captures ]]; then
    cp -r "$captures" "$system"/captures && rm -f "$system"/captures/*.xml || return 1
    echo '{"format": "procam-session", "version": 1, "pattern": "gray", "projector_size": [1024, 768], "board": "chessboard:7x9:75mm"}' \
      >"$system"/captures/session.json
    local -x PROCAM_CAPTURES=/captures
  fi
  mkdir "$system"/packages && cp "$out"/*.deb "$system"/packages && cp -r debian/tests "$system"/tests || return 1
  local apt="env DEBIAN_FRONTEND=noninteractive apt-get -y -qq --no-install-recommends"
  chroot "$system" $apt update >/dev/null || return 1
  local start=$SECONDS
  chroot "$system" sh -c "$apt install /packages/libprocam0_*.deb /packages/procam-tools_*.deb" >"$out"/install.log 2>&1 ||
    { tail "$out"/install.log && return 1; }
  echo "installed after $((SECONDS - start)) s"
  while read -r test; do
    depends=$(awk -v test="$test" 'BEGIN { RS = "" } $2 == test' debian/tests/control | sed -n 's/^Depends: //p' | tr -d ,)
    chroot "$system" sh -c "cd /packages && $apt install \$(for package in $depends; do ls ./\${package}_*.deb 2>/dev/null || echo \$package; done)" \
      >>"$out"/install.log 2>&1 || { tail "$out"/install.log && return 1; }
    start=$SECONDS
    if chroot "$system" /tests/"$test" >"$out"/"$test".log 2>&1; then
      echo "$test: passed after $((SECONDS - start)) s"
      grep -E '^[^:]+: [0-9]+ s$|^one rig' "$out"/"$test".log || true
    else
      echo "$test: FAILED" && tail -n 20 "$out"/"$test".log
      status=1
    fi
  done < <(sed -n 's/^Tests: //p' debian/tests/control)
  return "$status"
}

install_packages "${build_packages[@]}" "${package_packages[@]}" "${site_packages[@]}"
phase "packages" build_packages_of_commit
phase "lintian" look_by_lintian
if $reproducible; then phase "the same again" build_again_and_compare; fi
if $bare; then phase "a bare system" try_in_bare_system; fi
