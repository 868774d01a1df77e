# What the build, the tests and the samples need on Debian 12 (bookworm). Sourced by samples/quickstart.sh,
# samples/furniture_room.sh, tests/run.sh and tests/fuzz/run.sh.

RRO_PACKAGES=(cmake ninja-build g++ libembree-dev libopenmesh-dev catch2 nlohmann-json3-dev libcli11-dev libvalijson-dev
              libtinygltf-dev libtinyobjloader-dev libtbb-dev libopenexr-dev libpng-dev libjpeg62-turbo-dev zlib1g-dev libssl-dev
              flatbuffers-compiler python3)

# Besides, for tests/fuzz/run.sh alone.
RRO_FUZZ_PACKAGES=(clang libclang-rt-14-dev)

as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

# install_missing PACKAGE...: installs those that are not installed, and says which; asks for nothing if all are there.
install_missing() {
    local package missing=()
    for package in "$@"; do
        if [ "$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null)" != installed ]; then
            missing+=("$package")
        fi
    done
    if [ ${#missing[@]} -gt 0 ]; then
        echo "Installing: ${missing[*]}"
        as_root apt-get update --quiet
        as_root env DEBIAN_FRONTEND=noninteractive apt-get install --yes --quiet --no-install-recommends "${missing[@]}"
    fi
}
