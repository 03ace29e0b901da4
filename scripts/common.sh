# Functions shared by ./play and ./test: output, installation and building. Sourced by bash with $root (the checkout)
# and $command (the command's name) set.

say() { printf '%s\n' "$*"; }
fail() { printf '%s: %s\n' "$command" "$*" >&2; exit 2; }

# packages GROUP...: the words of these groups, one per line
packages() {
  local group
  for group; do sed -n "s/^$group: //p" "$root/scripts/packages"; done | tr ' ' '\n' | sort -u
}

installed() { [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }

# fetch_lists: fetches Debian's package lists if there are none yet
fetch_lists() {
  compgen -G '/var/lib/apt/lists/*Packages*' >/dev/null || update_lists
}

update_lists() {
  local log
  log=$(mktemp)
  say "  fetching Debian's package lists" >&2
  as_root apt-get update -q -o APT::Update::Error-Mode=any >"$log" 2>&1 ||
    fail "cannot fetch Debian's package lists; is there a network? ($(grep -m1 '^[EW]:' "$log"))"
  rm -f "$log"
}

# offered PACKAGE: whether Debian has it. For a name that only other packages mention, apt-cache succeeds and prints
# nothing.
offered() { [ -n "$(apt-cache show "$1" 2>/dev/null)" ]; }

# choose_packages WORD...: the packages that these words stand for in this release of Debian, one per line
choose_packages() {
  local word package
  for word; do
    case $word in *'|'* | *'?') ;; *) printf '%s\n' "$word"; continue ;; esac
    for package in ${word//[|?]/ }; do
      installed "$package" || { fetch_lists; offered "$package"; } || continue
      printf '%s\n' "$package"
      break
    done
  done
}

# progress LABEL TOTAL_PATTERN: shows a command's progress in steps of 10 %, as read from its output
progress() {
  awk -v label="$1" '
    match($0, /^\[[0-9]+\/[0-9]+\]/) {
      split(substr($0, 2, RLENGTH - 2), n, "/"); tenth = int(10 * n[1] / n[2])
    }
    /^(dl|pm)status:/ { split($0, f, ":"); tenth = int((/^dl/ ? 0 : 5) + f[3] / 20) }
    tenth > shown { shown = tenth; printf "  %s %d %%\n", label, 10 * tenth; fflush() }'
}

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }

# missing_packages GROUP...: lists the packages of these groups that are not installed
missing_packages() {
  local wanted
  # shellcheck disable=SC2046
  wanted=$(choose_packages $(packages "$@") | sort -u)
  # shellcheck disable=SC2086
  comm -13 <(dpkg-query -W -f '${db:Status-Abbrev}${Package}\n' $wanted 2>/dev/null |
               sed -n 's/^ii *//p' | sort -u) <(printf '%s\n' $wanted)
}

# can_install PACKAGE...: ends the command if this machine cannot install packages
can_install() {
  [ -e /etc/debian_version ] && command -v apt-get >/dev/null ||
    fail "set-up supports only Debian's packages; install by hand: $*"
  [ "$(id -u)" = 0 ] || command -v sudo >/dev/null ||
    fail "needs root or sudo to install: $*"
}

# set_up GROUP...: installs the missing packages of these groups; quick if none is missing
set_up() {
  local missing plan log
  missing=$(missing_packages "$@")
  [ -n "$missing" ] || return 0
  missing=$(echo $missing)
  can_install $missing
  say "Installing from Debian: $missing"
  log=$(mktemp)
  # With old or missing package lists the dry run fails; the lists are then fetched.
  if ! plan=$(apt-get install -s --no-install-recommends $missing 2>/dev/null); then
    update_lists
    plan=$(apt-get install -s --no-install-recommends $missing 2>"$log") ||
      fail "Debian cannot install these packages together: $(grep -m1 '^E:' "$log")"
  fi
  if grep -q '^Remv' <<<"$plan"; then
    fail "would remove $(sed -n 's/^Remv \([^ ]*\).*/\1/p' <<<"$plan" | tr '\n' ' ')from this machine; install by hand: $missing"
  fi
  say "  $(grep -c '^Inst' <<<"$plan") packages including dependencies"
  if ! as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends \
      -o APT::Status-Fd=3 -o DPkg::Lock::Timeout=120 $missing 3>&1 >"$log" 2>&1 | progress installed ||
     ! dpkg-query -W $missing >/dev/null 2>&1; then
    fail "could not install; is there a network? ($(grep -m1 '^E:' "$log"))"
  fi
  rm -f "$log"
}

# begin_set_up GROUP...: runs set_up in the background; $installer is its process, or empty if nothing is missing
begin_set_up() {
  local missing
  installer=''
  missing=$(missing_packages "$@")
  [ -n "$missing" ] || return 0
  can_install $missing
  as_root true # asks for a password now, if at all
  set_up "$@" &
  installer=$!
}

# Lets ccache use the compiler's own list of the files that a source includes, without preprocessing new files itself.
export CCACHE_DEPEND=1 CCACHE_SLOPPINESS=pch_defines,time_macros

# build_folder PRESET: prints the folder in which the preset builds
build_folder() {
  case $1 in release | library) printf '%s/build' "$root" ;; *) printf '%s/build-%s' "$root" "$1" ;; esac
}

# configure PRESET CMAKE-ARGUMENTS...: shows the end of the log on failure
configure() {
  local preset=$1 log
  log=$(build_folder "$preset")/build.log
  shift
  mkdir -p "${log%/*}"
  if ! (cd "$root" && cmake --preset "$preset" "$@") >"$log" 2>&1; then
    tail -n 30 "$log" >&2
    return 1
  fi
}

# build PRESET LABEL CMAKE-ARGUMENTS...: configures if needed, builds and shows progress; on failure shows the log. If
# the array `targets` is set, builds only these targets.
build() {
  local folder log preset=$1 label=$2
  shift 2
  folder=$(build_folder "$preset")
  log=$folder/build.log
  say "Building $label"
  configure "$preset" "$@" || return 1
  if ! nice ninja -C "$folder" ${targets+"${targets[@]}"} 2>&1 | tee -a "$log" | progress built; then
    grep -E -A12 'FAILED|error:' "$log" | head -n 60 >&2
    return 1
  fi
}
