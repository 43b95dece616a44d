# Completion of lucernad in fish: the options of its help, and files.
complete -c lucernad -a '(lucernad --help 2>/dev/null | string replace -rf "^  (?:-h,)?(--[a-z-]+).{0,27} (\\w.*)" "\$1\t\$2")'
