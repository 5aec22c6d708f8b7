# Bash completion of procam and its tools: option names, choices and files, from each tool's own --help. Nothing here
# changes when a tool gets an option.

declare -gA _procam_help_of=()

# The help of a tool, read once a shell. $1: the words that start the tool.
_procam_help() {
  [[ -n ${_procam_help_of[$1]+set} ]] || _procam_help_of[$1]=$($1 --help 2>/dev/null </dev/null)
  printf '%s\n' "${_procam_help_of[$1]}"
}

_procam() {
  local words=("${COMP_WORDS[@]}") at=$COMP_CWORD current=${COMP_WORDS[COMP_CWORD]} option tool value
  COMPREPLY=()
  tool=${words[0]/#\~/$HOME}
  if [[ ${tool##*/} == procam ]]; then
    if ((at == 1)); then
      mapfile -t COMPREPLY < <(compgen -W "$(_procam_help "$tool" | sed -nE 's/^  ([a-z][a-z-]+)  .*/\1/p') --help --version" -- "$current")
      return
    fi
    tool="$tool ${words[1]}"
  fi
  # Bash splits --option=value at the sign.
  option=${words[at - 1]}
  [[ $current == "=" ]] && current="" option=${words[at - 1]}
  [[ $option == "=" ]] && option=${words[at - 2]}
  if [[ $option == -* ]]; then
    # "  -o,--output FILE", "  --renderer {cpu,gl}=cpu"
    value=$(_procam_help "$tool" | sed -nE "s/^ +(-[a-z],)?$option [ ]*([^ ]+).*/\2/p; s/^ +$option,--[a-z-]+ [ ]*([^ ]+).*/\1/p" | head -n 1)
    case $value in
      FILE* | FOLDER*)
        compopt -o filenames 2>/dev/null
        mapfile -t COMPREPLY < <(compgen -f -- "$current")
        return
        ;;
      "{"*)
        value=${value#\{}
        mapfile -t COMPREPLY < <(compgen -W "$(tr , ' ' <<<"${value%%\}*}")" -- "$current")
        return
        ;;
      [A-Z]*) # a value that only the user knows; a file where one was begun
        compopt -o filenames 2>/dev/null
        [[ -n $current ]] && mapfile -t COMPREPLY < <(compgen -f -- "$current")
        return
        ;;
    esac
  fi
  if [[ $current == -* || -z $current ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(_procam_help "$tool" | sed -nE 's/^ +(-[a-z],)?(--[a-z][a-z-]*).*/\2/p')" -- "$current")
  else
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -f -- "$current")
  fi
}

complete -F _procam @tools@
