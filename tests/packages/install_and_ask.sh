# Runs in the new Debian: installs the packages and asks a question.
apt-get update -q
apt-get install -q -y --no-install-recommends -o Dpkg::Options::=--force-unsafe-io /root/packages/*.deb

lucerna --version
lucernad --version
lucernad --config /etc/lucernad/lucernad.toml --check-config | grep '/var/lib/lucernad/scenes'
getent passwd lucernad
# systemd makes these folders when the service starts.
install -d -o lucernad -g lucernad /var/lib/lucernad /var/lib/lucernad/scenes
cp /root/packages/*.pbrt /root/packages/*.ies /var/lib/lucernad/scenes

# The user and the settings of the service.
su -s /bin/sh lucernad -c 'exec lucernad --config /etc/lucernad/lucernad.toml' >/tmp/lucernad.log 2>&1 &
server=$!
until lucerna info >/dev/null 2>&1; do
  if ! kill -0 $server; then
    cat /tmp/lucernad.log
    exit 1
  fi
  sleep 0.5
done
lucerna power demo.pbrt
# The library that decodes pictures is found and has all that it needs.
library=$(echo /usr/lib/lucerna/lucerna-pictures-*.so)
if ldd "$library" | grep 'not found'; then exit 1; fi
# Each package has its manual page where man finds it.
for page in man1/lucerna.1 man1/lucerna-irradiance.1 man1/lucerna-tradeoff.1 man8/lucernad.8; do
  dpkg -L lucerna lucernad | grep "/usr/share/man/$page.gz"
done
