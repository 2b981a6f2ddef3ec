"""Install torch: the CPU build from an index that is named, else the build with GPU support.

Usage: install_torch.py VERSION [INDEX]. Part of setting up: runs before anything but pip is
installed.
"""

import subprocess
import sys
import urllib.request

PIP = [sys.executable, "-m", "pip"]


def answers(index):
    """Whether an index answers within a few seconds; pip would wait longer, for each package."""
    try:
        urllib.request.urlopen(f"{index}/torch/", timeout=5).close()
    except OSError:
        return False
    return True


def main(version, index=""):
    """Install the pinned version; a build that needs more packages than the CPU build gets them."""
    install = [*PIP, "install", "--quiet", f"torch=={version}"]
    if not index:
        subprocess.run(install, check=True)
        return
    if answers(index):
        install += ["--extra-index-url", index]
    else:
        sys.stderr.write(f"{index} does not answer: torch comes from where pip looks otherwise\n")
    subprocess.run([*install, "--no-deps"], check=True)
    if subprocess.run([*PIP, "check"], stdout=subprocess.DEVNULL, check=False).returncode:
        subprocess.run(install, check=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
