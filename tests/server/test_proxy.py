"""The page behind what people have: jupyter-server-proxy and web servers, which have it under a
path, and an SSH tunnel, which ends at another port."""

import contextlib
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from live import server
from live.browser import READY, page
from live.notebook import jupyter_environment
from live.visitor import PAPER, visitor

from beamviz.errors import InvalidInput
from beamviz.explorer import explorer
from beamviz.notebook import View
from beamviz.scene import Scene
from beamviz.server.access import key_of_file, public_url

KEY, TOKEN = "the-key-of-this-run", "the-token-of-jupyter"
SCENE = Scene(PAPER)
HERE = f"location.href.startsWith('{{}}') && {READY}"


@pytest.fixture(scope="module")
def jupyter(tmp_path_factory) -> Iterator[str]:
    """A Jupyter server with jupyter-server-proxy: the address under which it has a port."""
    folder, port = tmp_path_factory.mktemp("jupyter"), server.free_port()
    command = [sys.executable, "-m", "jupyter_server", "--no-browser", "--allow-root"]
    command += [
        f"--ServerApp.port={port}",
        "--ServerApp.port_retries=0",
        "--ServerApp.base_url=/lab/",
    ]
    command += [f"--IdentityProvider.token={TOKEN}"]
    settings = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(command, env=jupyter_environment(folder), **settings) as process:
        try:
            address = f"http://localhost:{port}"
            server.wait_until(lambda: answers(address))
            yield f"{address}/lab/proxy/{{port}}/"
        finally:
            process.terminate()


def answers(address: str) -> bool:
    """Whether a server has started."""
    with contextlib.suppress(OSError):
        return server.http_get(address, "/lab/api")[0] == 200
    return False


def login(jupyter: str) -> str:
    """The address that logs a browser in."""
    return f"{jupyter.partition('proxy/')[0]}?token={TOKEN}"


@pytest.mark.slow
def test_under_the_path_of_a_proxy_all_works(jupyter, tmp_path):
    """The link with the key, the WebSocket, edits, the address of a scene, an exported file. The
    cookie is sent to this server only, and the address has nothing of viser."""
    port = server.free_port()
    public = public_url(jupyter.format(port=port))
    with (
        explorer(SCENE, port=port, visitor_key=KEY, public=public) as found,
        page(login(jupyter)) as shown,
    ):
        shown.wait("document.readyState === 'complete' && location.search === ''")
        shown.call("Page.navigate", url=f"{found}&gamma=7")
        shown.wait(HERE.format(f"{public}/?gamma=7"))
        cookies = shown.call("Network.getCookies", urls=[f"{public}/"])["cookies"]
        (cookie,) = [one for one in cookies if one["value"] == KEY]
        assert (cookie["path"], cookie["httpOnly"]) == (f"/lab/proxy/{port}", True)
        shown.send("gamma", 12.5, until="location.search.includes('gamma=12.5')")
        link = shown.evaluate("location.href")
        assert link.startswith(f"{public}/?")
        assert not any(word in link for word in (KEY, "websocket"))
        shown.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
        shown.send("export", ".csv")
        server.wait_until(lambda: holds(tmp_path / "beam.csv", "frequency"))
        shown.call("Page.navigate", url="about:blank")
        shown.call("Page.navigate", url=link)
        shown.wait(HERE.format(link))
        assert shown.number("gamma") == 12.5
        assert not shown.problems


def holds(file: Path, words: str) -> bool:
    """Whether a file is there, with these words."""
    return file.exists() and words in file.read_text()


@pytest.mark.slow
def test_a_page_in_a_notebook_is_shown_through_its_proxy(jupyter):
    """In a frame of a page of the same address, where the browser is on another machine."""
    view = View(SCENE, jupyter)
    with contextlib.closing(view), page(login(jupyter)) as notebook:
        notebook.wait("document.readyState === 'complete' && location.search === ''")
        notebook.evaluate(f"document.body.innerHTML = `<iframe src='{view.url}'></iframe>`")
        notebook.wait(READY.replace("document", "frames[0].document"))
        notebook.evaluate("frames[0].eval(`beamviz.send('gamma', 12.5)`)")
        server.wait_until(lambda: view.scene.beam.gamma == 12.5)


@contextlib.contextmanager
def tunnel(port: int, path: str = "") -> Iterator[int]:
    """The local end of a tunnel to a port of this machine, as `ssh -L` makes it: bytes pass. With a
    path, a web server: it removes that from requests for what is below it, and refuses all others,
    as `handle_path /beams/*` of Caddy and `location /beams/` of nginx do."""

    def send(near: socket.socket, far: socket.socket) -> None:
        with contextlib.suppress(OSError):
            first, below = near.recv(65536), f"GET {path}/".encode()
            if path and not first.startswith(below):
                near.sendall(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n")
                near.shutdown(socket.SHUT_RDWR)
            else:
                far.sendall(first.replace(below, b"GET /", 1))
                forward(near, far)

    def forward(source: socket.socket, target: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                target.sendall(data)
        with contextlib.suppress(OSError):
            target.shutdown(socket.SHUT_RDWR)

    def accept() -> None:
        with contextlib.suppress(OSError):
            while True:
                near, far = listener.accept()[0], socket.create_connection(("127.0.0.1", port))
                ends.extend((near, far))
                for run, pair in ((send, (near, far)), (forward, (far, near))):
                    threads.append(threading.Thread(target=run, args=pair))
                    threads[-1].start()

    ends: list[socket.socket] = []
    threads = [threading.Thread(target=accept)]
    with socket.create_server(("127.0.0.1", 0)) as listener:
        threads[0].start()
        yield listener.getsockname()[1]
        listener.shutdown(socket.SHUT_RDWR)
    for end in ends:
        with contextlib.suppress(OSError):
            end.shutdown(socket.SHUT_RDWR)
        end.close()
    for thread in threads:
        thread.join(server.TIMEOUT)


@pytest.mark.slow
def test_a_web_server_may_pass_on_only_what_is_below_its_path():
    """viser would open its WebSocket at the path without the slash."""
    port = server.free_port()
    with tunnel(port, "/beams") as outer:
        public = public_url(f"http://localhost:{outer}/beams/")
        with (
            explorer(SCENE, port=port, visitor_key=KEY, public=public) as found,
            page(found) as shown,
        ):
            shown.wait(HERE.format(f"{public}/"))
            shown.send("gamma", 12.5, until="location.search.includes('gamma=12.5')")
            assert "websocket" not in shown.evaluate("location.href")
            shown.reload()
            shown.wait(f"{HERE.format(public)} && document.readyState === 'complete'")
            shown.wait(lambda: shown.number("gamma") == 12.5)


@pytest.mark.parametrize(("name", "key"), [("localhost", KEY), ("127.0.0.1", "")])
def test_a_tunnel_to_another_port_works(name, key):
    """With and without a key; a foreign page is refused there too."""
    host = "0.0.0.0" if key else "127.0.0.1"
    with (
        explorer(SCENE, host, visitor_key=key) as found,
        tunnel(int(found.split(":")[2].partition("/")[0])) as port,
    ):
        address, query = f"http://{name}:{port}", f"/?token={key}" if key else "/"
        status, headers, _ = server.http_get(address, query)
        assert (status, headers.get("Location")) == ((303, "/") if key else (200, None))
        with visitor(address + query, origin=address) as guest:
            guest.edit(gamma=12.0)
        for origin in ("http://evil.example", f"http://{name}:{port + 1}"):
            assert server.http_get(address, query, Origin=origin)[0] == 403


def test_servers_behind_one_address_let_the_same_visitors_in(tmp_path):
    """They share a key, and the cookie of one is that of all; the scene is in the address."""
    file = tmp_path / "key"
    file.write_text(f"{KEY}-of-several-servers\n")
    key = key_of_file(file)
    host, query = "beams.example.org", "gamma=12.5"
    options = {"visitor_key": key, "public": public_url(f"https://{host}")}
    ports = [server.free_port(), server.free_port()]
    first, second = (f"http://127.0.0.1:{port}" for port in ports)
    with contextlib.ExitStack() as stack:
        for port in ports:
            link = stack.enter_context(explorer(SCENE, port=port, **options))
            assert link == f"https://{host}/?token={key}"
        status, headers, _ = server.http_get(first, f"/?token={key}&{query}", Host=host)
        assert (status, headers["Location"]) == (303, f"https://{host}/?{query}")
        cookie = headers["Set-Cookie"].partition(";")[0]
        assert server.http_get(second, f"/?{query}", Host=host, Cookie=cookie)[0] == 200
        assert server.http_get(second, f"/?{query}", Host=host)[0] == 403


@pytest.mark.parametrize("text", ["", "short", "two keys\nof-more-than-22-characters", "ä" * 30])
def test_a_key_that_could_be_guessed_is_refused(tmp_path, text):
    file = tmp_path / "key"
    file.write_text(text)
    with pytest.raises(InvalidInput, match=r"key-file = .*openssl rand -hex 16"):
        key_of_file(file)
