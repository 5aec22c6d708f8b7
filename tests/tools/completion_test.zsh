#!/usr/bin/env zsh
# completion_test.zsh TOOLS: asks tools/completion/procam.zsh what it would complete, in a shell on a terminal of its own.
zmodload zsh/zpty || exit 1
tools=$1
scratch=$(mktemp -d)
mkdir $scratch/functions && cp $tools/completion/procam.zsh $scratch/functions/_procam && touch $scratch/rig.json || exit 1
failed=0

# expect NAME FOUND LINE: FOUND is in what the shell lists when Tab is pressed twice after LINE.
expect() {
  local seen="" part
  zpty shell "cd $scratch && zsh -f -i"
  zpty -w shell "PS1=; PATH=$tools:\$PATH; fpath=($scratch/functions \$fpath); autoload -U compinit; compinit -u -d $scratch/dump; setopt no_beep; zstyle ':completion:*' list-prompt ''; LISTMAX=1000; bindkey '^I' list-choices; print ready"
  zpty -r -m shell part '*ready*ready*'
  zpty -w -n shell "$3"$'\t'
  # The answer is there when the wanted text is, or after ten seconds not.
  local end=$((SECONDS + 10))
  while (( SECONDS < end )); do
    if zpty -r -t shell part; then seen+=$part; else sleep 0.05; fi
    [[ ${seen#*$3} == *$2* ]] && break
  done
  zpty -d shell
  if [[ ${seen#*$3} != *$2* ]]; then
    print -r -- "$1: '$2' expected after '$3', got: ${(V)seen}"
    failed=1
  fi
}

expect "a tool's name" "together, from a session" "procam cal"
expect "an option" "--holdout" "calibrate-projector --ho"
expect "an option by procam" "--holdout" "procam calibrate-projector --h"
expect "a choice" "free" "calibrate-projector --board-shape "
expect "a file" "rig.json" "solve-surfaces --rig r"
rm -rf $scratch
exit $failed
