"""Small networks on this computer: each worker in a namespace with an address of its own."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

import pytest


@dataclass(frozen=True)
class Network:
    """A bridge, and namespaces that are connected by it.

    Attributes:
        tag: the beginning of all names.
        host: the address of this computer on the bridge.
    """

    tag: str
    host: str

    def inside(self, place: str) -> list[str]:
        """Returns the words before a command that runs in a namespace."""
        return ["ip", "netns", "exec", f"{self.tag}-{place}"]

    def cut(self, place: str) -> None:
        """Pull the cable of a namespace: nothing arrives any more, and nobody is told."""
        _ip("link", "set", f"{self.tag}{place}", "down")

    def heal(self, place: str) -> None:
        """Plug it in again."""
        _ip("link", "set", f"{self.tag}{place}", "up")


@contextmanager
def network(*places: str) -> Iterator[Network]:
    """A network with these namespaces, as long as the block; skips the test where there can be none."""
    if shutil.which("ip") is None:
        pytest.skip("`ip` (iproute2) is not installed, so there are no network namespaces")
    if os.geteuid() != 0:
        pytest.skip("network namespaces need root")
    number = os.getpid() % 250
    tag, subnet = f"cu{number}", f"10.117.{number}"
    made = Network(tag, f"{subnet}.1")
    with ExitStack() as undo:
        try:
            _ip("link", "add", tag, "type", "bridge")
        except subprocess.CalledProcessError as error:
            pytest.skip(f"the kernel makes no bridge: {error.stderr.strip()}")
        undo.callback(_ip, "link", "del", tag)
        _ip("addr", "add", f"{subnet}.1/24", "dev", tag)
        _ip("link", "set", tag, "up")
        for i, place in enumerate(places, start=2):
            namespace = f"{tag}-{place}"
            _ip("netns", "add", namespace)
            undo.callback(_ip, "netns", "del", namespace)
            _ip("link", "add", f"{tag}{place}", "type", "veth", "peer", "name", "eth0", "netns", namespace)
            _ip("link", "set", f"{tag}{place}", "master", tag, "up")
            _ip("-n", namespace, "addr", "add", f"{subnet}.{i}/24", "dev", "eth0")
            _ip("-n", namespace, "link", "set", "eth0", "up")
            _ip("-n", namespace, "link", "set", "lo", "up")
        yield made


def _ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True, capture_output=True, text=True)
