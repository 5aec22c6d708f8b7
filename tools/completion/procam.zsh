#compdef @tools@
# Zsh completion of procam and its tools: options with their descriptions, choices and files, from each tool's own --help.

typeset -gA _procam_help_of

_procam_help() {
  (( ${+_procam_help_of[$1]} )) || _procam_help_of[$1]=$(${=1} --help 2>/dev/null </dev/null)
  print -r -- "$_procam_help_of[$1]"
}

_procam() {
  local tool=${words[1]} line option value
  local -a lines options
  if [[ ${tool:t} == procam ]]; then
    if (( CURRENT == 2 )); then
      for line in ${(f)"$(_procam_help $tool)"}; do
        [[ $line =~ '^  ([a-z][a-z-]+)  +(.*)$' ]] && options+=("$match[1]:$match[2]")
      done
      _describe tool options
      return
    fi
    tool="$tool ${words[2]}"
  fi
  lines=(${(f)"$(_procam_help $tool)"})
  option=${words[CURRENT-1]}
  if [[ $PREFIX == --*=* ]]; then
    option=${PREFIX%%=*}
    compset -P '*='
  fi
  if [[ $option == -* ]]; then
    for line in $lines; do
      if [[ $line =~ "^ +(-[a-z],)?${option} +([^ ]+)" || $line =~ "^ +(${option}),--[a-z-]+ +([^ ]+)" ]]; then
        value=$match[2]
        break
      fi
    done
    case $value in
      (FILE*|FOLDER*) _files; return ;;
      (\{*) value=${value#\{}; compadd -- ${(s:,:)value%%\}*}; return ;;
      ([A-Z]*) _message -r "$value"; _files; return ;;
    esac
  fi
  if [[ $PREFIX == -* || -z $PREFIX ]]; then
    for line in $lines; do
      [[ $line =~ '^ +(-[a-z],)?(--[a-z][a-z-]*)( +.*)?$' ]] && options+=("$match[2]:${match[3]## #}")
    done
    _describe option options
  else
    _files
  fi
}

_procam "$@"
