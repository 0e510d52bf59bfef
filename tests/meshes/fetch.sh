#!/bin/sh
# Brings the meshes of Debian's package libcgal-demo into a folder: fetch.sh FOLDER
# Nothing is installed and no other folder is written; root is not needed.
set -eu

package=libcgal-demo
folder=$1
work=$folder.part
rm -rf "$work"
mkdir -p "$work/lists" "$work/cache"
work=$(cd "$work" && pwd)

fail() {
    echo "meshes: $1" >&2
    exit 1
}

for tool in apt-get dpkg-deb; do
    command -v $tool >/dev/null || fail "needs $tool; elsewhere, put the files of $package's data/meshes into $folder"
done

# apt-get with package lists of our own, which any user may update.
apt_private() {
    apt-get -q -o "Dir::State::Lists=$work/lists" -o "Dir::Cache=$work/cache" -o "APT::Sandbox::User=$(id -un)" "$@"
}

here=$(pwd)
cd "$work"
echo "meshes: downloading $package (25 MB)"
apt-get -q download "$package" >apt.log 2>&1 ||
    { apt_private update && apt_private download "$package"; } >>apt.log 2>&1 ||
    { cat apt.log >&2; fail "cannot download $package"; }
dpkg-deb -x "$package"_*.deb package
tar -xzf package/usr/share/doc/libcgal-dev/data.tar.gz
cd "$here"
rm -rf "$folder"
mv "$work/data/meshes" "$folder"
rm -rf "$work"
echo "meshes: $(find "$folder" -type f | wc -l) files in $folder"
