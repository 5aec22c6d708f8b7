#!/usr/bin/env bash
# Follows README.md in a bare Debian 12 (debootstrap; needs root): a user who may use sudo clones the committed sources, runs
# the commands of "Get it" and of "One guided page" as they are written there, and a browser opens the page. Takes as long as
# a build of the libraries and tools by g++.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/common.sh

# The first block of shell commands under a heading of README.md.
commands_under() {
  awk -v heading="## $1" '$0 == heading { inside = 1 } inside && /^```$/ { exit } shell { print } inside && /^```sh$/ { shell = 1 }' README.md
}

make_system() {
  make_bare_system "$system" || return 1
  chroot "$system" sh -c "export DEBIAN_FRONTEND=noninteractive && apt-get -qq update && apt-get -y -qq --no-install-recommends install \
    sudo git ca-certificates >/dev/null && useradd -m -s /bin/bash visitor && echo 'visitor ALL=(ALL) NOPASSWD: ALL' >/etc/sudoers.d/visitor" ||
    return 1
  git clone -q . "$system"/home/visitor/procam && chroot "$system" chown -R visitor: /home/visitor/procam
}

as_visitor() {
  chroot "$system" su - visitor -c "set -e; cd procam; $1"
}

# The line of the README that needs no hardware, as it is in its sentence.
studio_command() {
  sed -n 's/.*`\(procam studio [a-z]* --simulate\)`.*/\1/p' README.md | head -n 1
}

open_page() {
  local url="" seen studio tries
  : >"$system"/studio.log
  as_visitor "cd ..; exec $(studio_command)" >"$system"/studio.log 2>&1 &
  studio=$!
  for ((tries = 0; tries < 100; ++tries)); do
    url=$(grep -oE 'http://[^ ]+' "$system"/studio.log | head -n 1) && break
    sleep 0.2
  done
  seen=$(chromium --headless --no-sandbox --disable-gpu --virtual-time-budget=5000 --dump-dom "$url" 2>/dev/null || true)
  pkill -INT -P "$studio" || true
  wait "$studio" || true
  if ! grep -q "Display" <<<"$seen"; then
    echo "the page is not open:" && cat "$system"/studio.log && return 1
  fi
  echo "$(studio_command): the page is open"
}

install_packages debootstrap chromium git
system=$(mktemp -d)
trap 'remove_bare_system "$system"' EXIT
phase "a bare system" make_system
phase "Get it" as_visitor "$(commands_under 'Get it')"
phase "the page" open_page
