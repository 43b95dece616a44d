# Completion of lucerna and lucerna-tradeoff in bash.  The program knows its commands, options and values.
# It needs the package bash-completion.
_lucerna() {
  local cur words cword line value
  _get_comp_words_by_ref -n =: cur words cword || return
  # Bash replaces only what is after the last "=".
  value=$cur
  [[ $cur != --*=* || $COMP_WORDBREAKS != *=* ]] || value=${cur#*=}
  COMPREPLY=()
  while IFS= read -r line; do
    case $line in
      :files)
        compopt -o filenames
        while IFS= read -r line; do COMPREPLY+=("$line"); done < <(compgen -f -- "$value")
        ;;
      :directories)
        compopt -o filenames
        while IFS= read -r line; do COMPREPLY+=("$line"); done < <(compgen -d -- "$value")
        ;;
      *)
        line=${line%%$'\t'*}
        COMPREPLY+=("${line#"${cur%"$value"}"}")
        ;;
    esac
  done < <("${words[0]}" __complete "${words[@]:1:cword}" 2>/dev/null)
  __ltrim_colon_completions "$cur"
}
complete -F _lucerna lucerna lucerna-tradeoff
