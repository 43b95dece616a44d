# Completion of lucernad in bash: the options of its help, and files.  It needs the package bash-completion.
_lucernad() {
  local cur prev
  _get_comp_words_by_ref -n : cur prev || return
  case $cur in
    -*) mapfile -t COMPREPLY < <(compgen -W "$("$1" --help 2>/dev/null | sed -n 's/^  \(--[a-z-]*\).*/\1/p')" -- "$cur") ;;
    *)
      compopt -o filenames
      mapfile -t COMPREPLY < <(compgen -f -- "$cur")
      ;;
  esac
}
complete -F _lucernad lucernad
