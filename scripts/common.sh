# Sourced by examples/run.sh and tests/run.sh: the packages procam needs on Debian 12, and phases that tell their time.

# What compiles the libraries and tools (by g++, and by Clang, which takes half the time); what the tests need besides.
# libopencv-dev brings OpenCV's CMake files; GLFW and OpenGL are for windows on a projector, libzip (found by pkg-config)
# for MPCDI archives, epoxy and EGL for drawing by OpenGL, OpenNI2 for depth sensors, Cyclone DDS for the ROS 2 graph,
# SQLite, zstd and lz4 for its logs, Highway for drawing by AVX2 and NEON, and the library builds without them; Xvfb is
# the screen that the tests look at, Mesa's EGL and drivers draw without a graphics card, Chromium is the browser that
# shows the reports, Blender and Godot are asked whether their cameras look where export-camera says, Fast DDS is a peer
# of another vendor in the ROS 2 graph; pybind11 and numpy are for the Python package,
# pytest and mypy for its tests, nbclient, ipykernel and Matplotlib for its notebooks, colcon for a workspace of ROS.
build_packages=(g++ clang cmake ninja-build libeigen3-dev libopencv-dev libceres-dev nlohmann-json3-dev libpugixml-dev
  libcli11-dev libboost-dev libglfw3-dev libgl-dev pkg-config libzip-dev libepoxy-dev libegl-dev libopenni2-dev
  cyclonedds-dev cyclonedds-tools libsqlite3-dev libzstd-dev liblz4-dev libhwy-dev)
test_packages=(lld libgtest-dev libbenchmark-dev libclang-rt-dev clang-format clang-tidy xvfb libx11-dev libegl-mesa0
  libgl1-mesa-dri chromium blender godot3 pybind11-dev python3-dev python3-numpy python3-pytest mypy zsh abigail-tools
  libfastrtps-dev python3-nbclient python3-ipykernel python3-matplotlib colcon python3-colcon-cmake python3-colcon-ros
  python3-colcon-recursive-crawl)
# The fuzz targets (tests/fuzz/run.sh): libFuzzer is part of libclang-rt-dev; llvm has the symbolizer, without which a
# finding's stack has no names.
fuzz_packages=(clang lld libclang-rt-dev llvm)
# The Debian packages and a bare system to try them in (scripts/packages.sh).
package_packages=(dpkg-dev debhelper dh-python help2man lintian debootstrap pybind11-dev python3-dev python3-numpy)
# A release compares the interface with the last one's (scripts/abi.sh).
release_packages=(abigail-tools)
# For arm64 (scripts/arm64.sh): what runs here, and the libraries of arm64.
arm64_packages=(clang lld cmake ninja-build mmdebstrap qemu-user-static)
arm64_libraries=(libc6-dev libstdc++-12-dev libgcc-12-dev libeigen3-dev libopencv-dev libceres-dev libblas-dev liblapack-dev
  nlohmann-json3-dev libpugixml-dev libcli11-dev libboost-dev libzip-dev libgtest-dev libhwy-dev)
# The site (scripts/site.sh).
site_packages=(doxygen graphviz python3-sphinx python3-myst-parser furo)

# install_packages PACKAGE...: installs those that are missing, and asks for no more rights than that needs.
install_packages() {
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    echo "No apt here: please see to it that the like of these is installed: $*"
    return 0
  fi
  local package missing=() as_root=()
  for package in "$@"; do
    if [[ "$(dpkg-query -W -f='${db:Status-Abbrev}' "$package" 2>/dev/null || true)" != ii* ]]; then
      missing+=("$package")
    fi
  done
  if ((${#missing[@]} == 0)); then
    echo "All packages are installed."
    return 0
  fi
  if ((EUID != 0)); then
    if ! command -v sudo >/dev/null || { ! sudo -n true 2>/dev/null && [[ ! -t 0 ]]; }; then
      echo "These packages are missing, and installing them needs root:" >&2
      echo "  apt-get install --no-install-recommends ${missing[*]}" >&2
      return 1
    fi
    as_root=(sudo)
  fi
  echo "Installing: ${missing[*]}"
  local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300)
  "${apt[@]}" update </dev/null
  "${apt[@]}" install -y --no-install-recommends "${missing[@]}" </dev/null >/dev/null
}

# phase TITLE COMMAND...: runs the command, tells what it is before and how long it took after; returns its status.
phase() {
  local title=$1 start=$SECONDS status=0
  shift
  printf '\n== %s\n' "$title"
  "$@" || status=$?
  printf '== %s: %s after %d s\n' "$title" "$([[ $status == 0 ]] && echo done || echo "FAILED ($status)")" \
    "$((SECONDS - start))"
  return "$status"
}

# make_bare_system FOLDER: a Debian 12 with nothing but its base in it; needs root.
make_bare_system() {
  debootstrap --variant=minbase bookworm "$1" >"$1".log 2>&1 || { tail "$1".log && return 1; }
  chmod 755 "$1" && mount --bind /proc "$1"/proc && mount --bind /dev "$1"/dev && mount --bind /dev/pts "$1"/dev/pts
}

remove_bare_system() {
  umount "$1"/proc "$1"/dev/pts "$1"/dev 2>/dev/null || true
  rm -rf --one-file-system "$1" "$1".log
}
