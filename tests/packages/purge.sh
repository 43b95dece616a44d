# Runs in the new Debian: removes the packages, then purges them.
names=$(dpkg-query -W -f '${binary:Package}\n' '*lucern*')
apt-get remove -q -y $names
if command -v lucerna || command -v lucernad; then exit 1; fi
# Settings and scenes stay until the purge.
test -f /etc/lucernad/lucernad.toml
test -d /var/lib/lucernad/scenes
dpkg --purge $names
