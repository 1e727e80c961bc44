# Completion of vitrine for bash: commands, the options that a command's own help names, files.
_vitrine() {
  local word="${COMP_WORDS[COMP_CWORD]}" text
  if [ "$COMP_CWORD" -eq 1 ]; then
    text="$("${COMP_WORDS[0]}" --help 2>/dev/null | sed -n 's/^  \([a-z]*\) .*/\1/p')"
  elif [[ "$word" == -* ]]; then
    text="$("${COMP_WORDS[0]}" "${COMP_WORDS[1]}" --help 2>/dev/null | grep -oE '^ +(-[a-z], +)?--[a-z-]+|^ +-[a-z], ' | grep -oE -- '--?[a-z-]+')"
  else
    return # -o default: files
  fi
  mapfile -t COMPREPLY < <(compgen -W "$text" -- "$word")
}
complete -o default -o filenames -F _vitrine vitrine
