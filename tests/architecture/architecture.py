#!/usr/bin/env python3
"""Checks of the shape of the tree. Each prints one line per violation and exits 1 if there are any.

  architecture.py includes ROOT             who includes whom, and what the pure core may not include or call
  architecture.py symbols --nm NM LIB...    what the pure core's archives would take from outside
  architecture.py paths ROOT                absolute paths of somebody's machine in the repository's files
  architecture.py cases ROOT                tests that pages name and nobody has written; cases and claims without one
  architecture.py house ROOT                the picture in CONTRIBUTING.md against CORE_ORDER
"""

import argparse
import glob
import os
import re
import shutil
import subprocess
import sys

# A folder may include itself and those to its left.
CORE_ORDER = ["model", "link", "scenarios", "world", "sync", "delivery", "reckoning", "shown", "wire", "capture", "trace", "channel", "replica", "session", "paths", "membership", "participant", "crowd", "monitor"]

# The shell under the programs stands on the core alone, and no program stands on another.
BESIDE = {"shell": ("peer", "tools"), "peer": ("tools",), "tools": ("peer",)}

# The generated header of a .proto file belongs to one folder; everybody else sees plain structs.
PROTO_OWNER = {"wire.pb.h": "wire", "trace.pb.h": "trace", "scenario.pb.h": "scenarios", "monitor.pb.h": "monitor"}

# Standard and system headers that bring time, threads, files, sockets or other hidden input.
IMPURE_HEADERS = {
    "chrono", "ctime", "time.h", "sys/time.h", "sys/times.h", "sys/timerfd.h",
    "thread", "mutex", "shared_mutex", "condition_variable", "future", "stop_token", "semaphore", "barrier", "latch",
    "pthread.h", "threads.h", "sys/random.h",
    "fstream", "filesystem", "iostream", "fcntl.h", "unistd.h", "sys/stat.h", "sys/mman.h",
    "dirent.h",
    "sys/socket.h", "netinet/in.h", "arpa/inet.h", "netdb.h", "poll.h", "sys/select.h", "sys/epoll.h", "ifaddrs.h",
    "csignal", "signal.h",
}  # fmt: skip
IMPURE_HEADER_PREFIXES = ("boost/asio", "asio", "spdlog/", "CLI/")

# Names that have no business in the core, whatever header they came by.
IMPURE_NAMES = re.compile(
    r"\b(?:std::random_device|random_device|(?:system|steady|high_resolution)_clock|(?:secure_)?getenv|"
    r"clock_gettime|gettimeofday|std::time|std::clock|std::thread|std::jthread|std::mutex|std::rand|srand|"
    r"std::[io]?fstream|std::filesystem|std::cout|std::cerr|std::cin|fopen|"
    r"(?:std::)?(?:printf|fprintf|puts|fputs|fwrite))\b"
)

# What may come out otherwise on another processor or with another library, and so would make worlds differ: functions whose
# last bit is the C library's choice (model/portable_math.h has its own), orders and draws that are the standard library's,
# types that have other sizes or follow the locale. Square root, floor and remainder are exact everywhere.
UNPORTABLE_NAMES = re.compile(
    r"\b(?:std::(?:exp2?|expm1|log|log2|log10|log1p|pow|cbrt|hypot|a?sinh?|a?cosh?|a?tanh?|atan2|erfc?|[tl]gamma)|"
    r"(?:exp2?|expm1|log|log2|log10|log1p|pow|cbrt|hypot|a?sin|a?cos|a?tan|atan2|sincos)[fl](?=\()|"
    r"std::(?:unordered_\w+|hash|default_random_engine|mt19937\w*|\w+_distribution|shuffle|sample|generate_canonical|"
    r"(?:transform_)?reduce|execution)|"
    r"std::(?:sto[dflu]\w*|strto\w+|ato[fil]\w*|setlocale|locale)|(?<!long )long(?! long)|wchar_t)\b"
)
# They replace the C library's by their own, and look at what came of it.
UNPORTABLE_MAY = {"common/world/box2d_math.cpp", "common/world/fingerprint.cpp"}

# What `nm -u -C` may not show. Plain C symbols are compared whole, C++ ones by their start.
IMPURE_C_SYMBOLS = {
    # clocks and waiting
    "clock", "clock_gettime", "clock_getres", "clock_nanosleep", "ftime", "gettimeofday", "localtime", "gmtime",
    "localtime_r", "nanosleep", "sleep", "time", "timer_create", "timerfd_create", "times", "timespec_get", "usleep",
    # randomness without a seed of ours
    "arc4random", "drand48", "getentropy", "getrandom", "lrand48", "mrand48", "rand", "rand_r", "random", "srand",
    "srandom",
    # environment, processes, signals
    "environ", "execve", "execvp", "fork", "getenv", "gethostname", "getpid", "getuid", "kill", "popen",
    "posix_spawn", "putenv", "raise", "secure_getenv", "setenv", "sigaction", "signal", "system", "uname",
    # threads; not pthread_once, which protobuf's headers use to build a table at its first use
    "pthread_cond_signal", "pthread_cond_wait", "pthread_create", "pthread_join", "pthread_mutex_lock",
    "pthread_mutex_unlock", "pthread_rwlock_rdlock", "pthread_rwlock_wrlock", "thrd_create",
    # files and the terminal
    "access", "close", "creat", "creat64", "fclose", "fdopen", "fgets", "fopen", "fopen64", "fprintf", "fputs",
    "fread", "freopen", "fscanf", "fwrite", "getchar", "getcwd", "ioctl", "lstat", "mkdir", "mkstemp", "mmap",
    "mmap64", "open", "open64", "openat", "opendir", "perror", "printf", "putchar", "puts", "read", "readdir",
    "readlink", "realpath", "remove", "rename", "scanf", "stat", "stderr", "stdin", "stdout", "tmpfile", "unlink",
    "vfprintf", "vprintf", "write",
    # sockets
    "accept", "accept4", "bind", "connect", "epoll_create1", "epoll_wait", "getaddrinfo", "gethostbyname",
    "getifaddrs", "getsockname", "getsockopt", "if_nametoindex", "listen", "poll", "ppoll", "recv", "recvfrom",
    "recvmmsg", "recvmsg", "select", "send", "sendmmsg", "sendmsg", "sendto", "setsockopt", "shutdown", "socket",
    "socketpair",
}  # fmt: skip
IMPURE_CXX_SYMBOLS = re.compile(
    r"(?:.*\b)?(?:std::random_device\b|std::chrono::.*\bnow\(|std::thread\b|std::this_thread\b|std::jthread\b|"
    r"std::(?:recursive_|shared_|timed_)*mutex\b|std::condition_variable|std::__condvar|std::__future_base|"
    r"std::basic_[io]?fstream|std::basic_filebuf|std::filesystem|std::cout\b|std::cerr\b|std::clog\b|std::cin\b|"
    r"boost::asio|spdlog::)"
)

SOURCE_SUFFIXES = (".h", ".cpp", ".inc")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def without_comments_and_strings(text):
    """Source text with comments and literals blanked, line numbers kept; include lines are left alone."""
    pattern = re.compile(
        r'(?P<keep>^[ \t]*#[ \t]*include[^\n]*)|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'',
        re.S | re.M,
    )
    return pattern.sub(lambda m: m.group("keep") or "\n" * m.group(0).count("\n"), text)


def sources(root, top):
    for folder, folders, names in os.walk(os.path.join(root, top)):
        folders.sort()
        for name in sorted(names):
            if name.endswith(SOURCE_SUFFIXES):
                yield os.path.relpath(os.path.join(folder, name), root)


def check_include(root, path, kind, name):
    """Yields what is wrong with one include line of one file of the core, the shell, peer or tools."""
    base = os.path.basename(name)
    part = path.split("/")
    own = part[1] if part[0] == "common" else None

    if base.endswith(".pb.h") and not name.startswith("google/"):
        if base not in PROTO_OWNER:
            yield f"{name} has no owner: name its folder in PROTO_OWNER"
        elif own != PROTO_OWNER[base]:
            yield f"{name} belongs to common/{PROTO_OWNER[base]}"
    if name.split("/")[0] in BESIDE.get(part[0], ()):
        yield f"{part[0]}/ may not include {name}"
    if own is None:
        return

    if kind == '"' and not os.path.exists(os.path.join(root, name)):
        if os.path.exists(os.path.join(root, os.path.dirname(path), name)):
            yield f'"{name}" is to be written from the repository root'
            return
    top = name.split("/")
    if top[0] == "common" and len(top) > 2:
        if top[1] not in CORE_ORDER:
            yield f"{name}: common/{top[1]} is not in CORE_ORDER"
        elif CORE_ORDER.index(top[1]) > CORE_ORDER.index(own):
            yield f"{name} points up: common/{own} may not use common/{top[1]}"
    elif top[0] in ("shell", "peer", "tools", "tests"):
        yield f"{name}: the core includes nothing of {top[0]}/"

    if (name.startswith("box2d/") or base in ("box2d.h", "box2d_access.h")) and own != "world":
        yield f"{name}: common/world alone knows Box2D"
    if name.startswith("google/protobuf/") and own not in PROTO_OWNER.values():
        yield f"{name}: protobuf stays in {', '.join('common/' + o for o in sorted(set(PROTO_OWNER.values())))}"
    if name in IMPURE_HEADERS or name.startswith(IMPURE_HEADER_PREFIXES):
        yield f"{name}: no clocks, threads, files, sockets or logs in the core"


def includes(root):
    found = []
    for path in [p for top in ("common", "shell", "peer", "tools") for p in sources(root, top)]:
        in_core = path.startswith("common/")
        if in_core and (path.count("/") < 2 or path.split("/")[1] not in CORE_ORDER):
            found.append(f"{path}: its folder is not in CORE_ORDER")
            continue
        with open(os.path.join(root, path), encoding="utf-8") as file:
            text = without_comments_and_strings(file.read())
        for number, line in enumerate(text.split("\n"), 1):
            match = INCLUDE.match(line)
            if match:
                found += [f"{path}:{number}: {what}" for what in check_include(root, path, *match.groups())]
            elif in_core:
                for name in IMPURE_NAMES.findall(line):
                    found.append(f"{path}:{number}: {name} has no place in the core")
                for name in [] if path in UNPORTABLE_MAY else UNPORTABLE_NAMES.findall(line):
                    found.append(f"{path}:{number}: {name} may be another on another machine")
    return found


def impure_symbol(symbol):
    plain = re.sub(r"@.*$", "", symbol)
    # The fortified and the 64-bit names of the same functions.
    plain = re.sub(r"^__(\w+)_chk$", r"\1", plain)
    return plain in IMPURE_C_SYMBOLS or IMPURE_CXX_SYMBOLS.match(symbol) is not None


def symbols(nm, archives):
    """Undefined symbols of our own objects; those that protoc generated bring protobuf's own ones along."""
    found = []
    for archive in archives:
        listing = subprocess.run([nm, "-u", "-C", archive], capture_output=True, text=True, check=True).stdout
        member = ""
        for line in listing.split("\n"):
            if line.endswith(":") and not line.startswith(" "):
                member = line[:-1]
            match = re.match(r"^\s+U (.+)$", line)
            if match and ".pb.cc" not in member and impure_symbol(match.group(1)):
                found.append(f"{os.path.basename(archive)}: {member}: {match.group(1)}")
    return found


# Built from pieces, so that this file passes its own check. A path that only starts with a variable is fine.
MACHINE_PATH = re.compile(
    r"(?<![\w.$}/~-])/(?:" + "|".join(["ho" + "me", "Use" + "rs", "ro" + "ot", "tm" + "p", "wo" + "rk", "mn" + "t"])
    + r")/[\w.]"
)  # fmt: skip


def repository_files(root):
    """What git knows or could know; without git, or outside of a clone, everything but what builds and runs leave."""
    if shutil.which("git") and os.path.exists(os.path.join(root, ".git")):
        command = ["git", "-C", root, "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
        listing = subprocess.run(command, capture_output=True, check=False)
        if listing.returncode == 0:
            return sorted(set(name.decode() for name in listing.stdout.split(b"\0") if name))
    names = []
    for folder, folders, files in os.walk(root):
        folders[:] = sorted(f for f in folders if not (folder == root and f in (".git", "build", "out")))
        names += [os.path.relpath(os.path.join(folder, name), root) for name in sorted(files)]
    return names


def paths(root):
    found = []
    for name in repository_files(root):
        full = os.path.join(root, name)
        if not os.path.isfile(full):
            continue
        with open(full, "rb") as file:
            data = file.read()
        if b"\0" in data:
            continue
        for number, line in enumerate(data.decode("utf-8", "replace").split("\n"), 1):
            match = MACHINE_PATH.search(line)
            if match:
                found.append(f"{name}:{number}: {line.strip()[:120]}")
    return found


TEST_NAME = re.compile(r"`(\w+\.\w+)`")
NAMED_TEST = re.compile(r"`([A-Z]\w+\.[A-Z]\w+)`")
TEST_DEFINITION = re.compile(r"^TEST(?:_F|_P)?\((\w+), *(\w+)\)", re.MULTILINE)


def cases(root):
    written = set()
    for path in sources(root, "tests"):
        with open(os.path.join(root, path), encoding="utf-8") as file:
            written.update(".".join(m) for m in TEST_DEFINITION.findall(file.read()))
    for path in glob.glob(os.path.join(root, "tests/*/CMakeLists.txt")):
        with open(path, encoding="utf-8") as file:
            written.update(re.findall(r"add_test\(NAME ([A-Z]\w+\.\w+)", file.read()))
    found = cases_of(root, "docs/cases.md", "case", written) + cases_of(root, "docs/trust.md", "claim", written)
    for page in sorted(name for name in repository_files(root) if re.fullmatch(r"docs/[^/]+\.md", name)):
        with open(os.path.join(root, page), encoding="utf-8") as file:
            for number, line in enumerate(file, 1):
                named = NAMED_TEST.findall(line)
                found += [f"{page}:{number}: there is no test {name}" for name in named if name not in written]
    return sorted(set(found))


def cases_of(root, page, head, written):
    """Each row of a page's table names at least one test, and only tests that are written."""
    found = []
    with open(os.path.join(root, page), encoding="utf-8") as file:
        rows = [(n, line) for n, line in enumerate(file, 1) if line.startswith("| ") and not line.startswith(f"| {head} ")]
    if not rows:
        return [f"{page}: no cases"]
    for number, line in rows:
        named = TEST_NAME.findall(line)
        if not named:
            found.append(f"{page}:{number}: a case without a test: {line.split('|')[1].strip()}")
        found += [f"{page}:{number}: there is no test {name}" for name in named if name not in written]
    return found


def house(root):
    """The picture has every folder of the core once, from the top down, and an arrow between two of them."""
    page = "CONTRIBUTING.md"
    with open(os.path.join(root, page), encoding="utf-8") as file:
        picture = re.search(r"^## The house\n(.*?)^## ", file.read(), re.S | re.M)
    if not picture:
        return [f"{page}: no section 'The house'"]
    shown = re.findall(r"^ {4}common/(\w+)/ ", picture[1], re.M)
    if shown != CORE_ORDER[::-1]:
        return [f"{page}: the picture has {', '.join(shown)}; from the top down it should be {', '.join(CORE_ORDER[::-1])}"]
    arrows = len(re.findall(r"^ +v$", picture[1], re.M))
    return [] if arrows == len(shown) else [f"{page}: {arrows} arrows for {len(shown)} folders below the shell"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    verbs = parser.add_subparsers(dest="verb", required=True)
    verbs.add_parser("includes").add_argument("root")
    verb = verbs.add_parser("symbols")
    verb.add_argument("--nm", default="nm")
    verb.add_argument("archives", nargs="+")
    verbs.add_parser("paths").add_argument("root")
    verbs.add_parser("cases").add_argument("root")
    verbs.add_parser("house").add_argument("root")
    args = parser.parse_args()

    if args.verb == "includes":
        found = includes(args.root)
    elif args.verb == "symbols":
        found = symbols(args.nm, args.archives)
    elif args.verb == "cases":
        found = cases(args.root)
    elif args.verb == "house":
        found = house(args.root)
    else:
        found = paths(args.root)
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
