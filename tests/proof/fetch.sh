#!/bin/bash
# Brings CBMC and kissat into a directory, DIR/bin/cbmc and so on: tests/proof/fetch.sh DIR
#
# Debian 12 has an older CBMC and no kissat. The packages of the next release are unpacked beside the system, with their
# own libraries and a private apt directory, from the mirror that this machine's apt already uses: nothing is installed.
set -eu
mkdir -p "$1"
dir=$(cd "$1" && pwd)
suite=${CBMC_SUITE:-trixie}
tools="cbmc goto-cc goto-instrument kissat"
packages="cbmc minisat kissat libc6 libstdc++6 libgcc-s1 zlib1g"
keyring=/usr/share/keyrings/debian-archive-keyring.gpg
[ -e "$dir/complete" ] && exit 0

# The first mirror of the distribution in either format of apt's sources.
mirror() {
    apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Label: Debian' | head -n 1
}

private_apt() {
    apt-get -o Dir="$dir/apt" -o Dir::State::status="$dir/apt/var/lib/dpkg/status" -o APT::Sandbox::User=root \
        -o APT::Architecture=amd64 -o APT::Architectures=amd64 -o Acquire::Languages=none "$@"
}

wrap() { # program
    local libraries=$dir/root/usr/lib/x86_64-linux-gnu:$dir/root/usr/lib loader
    loader=$(find "$dir/root" -name ld-linux-x86-64.so.2 | head -n 1)
    printf '#!/bin/sh\nexec %s --library-path %s --argv0 %s %s "$@"\n' "$loader" "$libraries" "$1" \
        "$dir/root/usr/bin/$1" >"$dir/bin/$1"
    chmod +x "$dir/bin/$1"
}

uri=$(mirror)
test -n "$uri"
mkdir -p "$dir"/apt/etc/apt/{sources.list.d,preferences.d,apt.conf.d,trusted.gpg.d} "$dir/apt/var/lib/dpkg" \
    "$dir"/apt/var/lib/apt/lists/partial "$dir"/apt/var/cache/apt/archives/partial "$dir"/{debs,root,bin}
touch "$dir/apt/var/lib/dpkg/status"
echo "deb [signed-by=$keyring] $uri $suite main" >"$dir/apt/etc/apt/sources.list"
private_apt -q update
(cd "$dir/debs" && private_apt -q download $packages)
for package in "$dir"/debs/*.deb; do dpkg-deb -x "$package" "$dir/root"; done
for tool in $tools; do wrap "$tool"; done
"$dir/bin/cbmc" --version
"$dir/bin/kissat" --version
rm -rf "$dir/debs" "$dir/apt"
touch "$dir/complete"
