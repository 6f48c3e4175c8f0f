"""Who is let in: the server's door, tried from outside."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from websockets.datastructures import Headers
from websockets.exceptions import InvalidStatus
from websockets.http11 import Request

from rnnpb_explorer.app.page.door import Door, address_for_others, make_door
from rnnpb_explorer.app.page.server import App, ServerOptions, start
from rnnpb_explorer.core.checkpoint import save_checkpoint
from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.core.model import RNNPB

from .door_knocks import CAME_IN, ask, knock, port_of
from .wire_browser import WireBrowser

TOKEN = "ab?&=ä+%"  # whatever a person makes up; in a URL it is quoted
Serve = Callable[..., App]


@pytest.fixture
def serve(tiny_model: RNNPB, tmp_path: Path) -> Iterator[Serve]:
    path = tmp_path / "tiny.pt"
    save_checkpoint(tiny_model, path)
    running: list[App] = []

    def start_one(**options: object) -> App:
        running.append(start(ServerOptions(checkpoints=(str(path),), port=0, **options)))  # type: ignore[arg-type]
        return running[-1]

    yield start_one
    for app in running:
        app.stop()


@pytest.fixture
def app(serve: Serve) -> App:
    return serve()


def works(app: App, **options: object) -> None:
    """A page of ours opens and gets its screen."""
    browser = WireBrowser(app.url, **options)  # type: ignore[arg-type]
    browser.widget("Motion")
    browser.leave()


# --- names and origins ---
FOREIGN_ORIGINS = [
    "http://evil.example",
    "null",
    "http://127.0.0.1",
    "http://127.0.0.1:{port}1",
    "http://127.0.0.1:{port}.evil.example",
    "http://127.0.0.1.evil.example:{port}",
    "http://evil.example/http://127.0.0.1:{port}",
    "http://127.0.0.1:{port}@evil.example",
    "http://127.0.0.1:{other}",
    "http://localhost:{port}",  # ours by name, but not the page that was asked for
    "https://127.0.0.1:{port}",
    "ws://127.0.0.1:{port}",
    "file://",
    "",
]


@pytest.mark.parametrize("origin", FOREIGN_ORIGINS)
def test_a_page_of_another_site_gets_nothing(app: App, origin: str) -> None:
    port = port_of(app)
    origin = origin.format(port=port, other=port - 1)
    for answer in (knock(app, Origin=origin), ask(app, Origin=origin)):
        assert answer.status == 403
        assert answer.headers["content-type"].startswith("text/plain")
        assert "other sites" in answer.text
    assert app.sessions == {}
    works(app)


FOREIGN_HOSTS = [
    "evil.example",
    "evil.example:{port}",
    "127.0.0.1",
    "127.0.0.1:{other}",
    "127.0.0.1:{port}1",
    "127.0.0.1:0{port}",
    "127.0.0.1.evil.example:{port}",
    "127.0.0.2:{port}",
    "localhost.:{port}",
    "0.0.0.0:{port}",
    "user@127.0.0.1:{port}",
    "",
]


@pytest.mark.parametrize("host", FOREIGN_HOSTS)
def test_a_name_that_was_bound_to_this_address_gets_nothing(app: App, host: str) -> None:
    port = port_of(app)
    host = host.format(port=port, other=port - 1)
    for answer in (
        knock(app, host=host),
        ask(app, host=host),
        knock(app, host=host, Origin=f"http://{host}"),  # the browser of a rebound name says so
    ):
        assert answer.status == 403
        assert "that name" in answer.text
    assert app.sessions == {}
    works(app)


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost", "LocalHost", "[::1]"])
def test_our_own_page_comes_in_under_every_name_of_this_machine(app: App, name: str) -> None:
    host = f"{name}:{port_of(app)}"
    assert ask(app, host=host).status == 200
    assert ask(app, host=host, Origin=f"http://{host.lower()}").status == 200
    assert knock(app, host=host, Origin=f"http://{host.lower()}").status == CAME_IN


def test_tools_say_no_origin_and_come_in(app: App) -> None:
    assert knock(app).status == CAME_IN


@pytest.mark.parametrize("header", ["Host", "Origin"])
def test_what_is_said_twice_is_not_believed(header: str) -> None:
    own = {"Host": "127.0.0.1:8080", "Origin": "http://127.0.0.1:8080"}
    headers = Headers(own)
    assert Door("127.0.0.1").answer(Request("/", headers), ("127.0.0.1", 8080)) is None
    headers[header] = own[header]  # websockets' headers keep both
    answer = Door("127.0.0.1").answer(Request("/", headers), ("127.0.0.1", 8080))
    assert answer is not None
    assert answer.status_code == 403


def test_a_proxy_is_known_by_its_name(serve: Serve) -> None:
    app = serve(allow_origins=("https://Course.example", "http://lab:81"))
    for host in ("course.example", "course.example:443", "lab:81", app.url[7:]):
        assert ask(app, host=host).status == 200
        for origin in ("https://course.example", "http://lab:81"):
            assert knock(app, host=host, Origin=origin).status == CAME_IN
    for origin in ("http://course.example", "https://course.example:81", "https://lab:81"):
        assert knock(app, Origin=origin).status == 403
    for host in ("course.example:80", "lab", "www.course.example"):
        assert ask(app, host=host).status == 403
    assert "wss://course.example" in ask(app).policy["connect-src"].split()


@pytest.mark.parametrize(
    ("bound", "address", "served", "refused"),
    [
        ("0.0.0.0", ("192.0.2.7", 80), ["192.0.2.7", "192.0.2.7:80", "localhost"], ["192.0.2.8"]),
        ("0.0.0.0", ("192.0.2.7", 81), ["192.0.2.7:81"], ["192.0.2.7", "192.0.2.7:80", "lab:81"]),
        (
            "::",
            (
                "2001:db8::1",
                81,
            ),
            ["[2001:db8::1]:81", "[::1]:81"],
            ["2001:db8::1:81"],
        ),
        ("::", ("::ffff:192.0.2.7", 81), ["192.0.2.7:81"], ["[::ffff:192.0.2.7]:81"]),
        ("::", ("fe80::1%eth0", 81), ["[fe80::1]:81"], ["[fe80::1%eth0]:81"]),
        ("lab", ("192.0.2.7", 81), ["lab:81", "LAB:81"], ["192.0.2.7:81", "localhost:81"]),
        ("127.0.0.5", ("127.0.0.5", 81), ["127.0.0.5:81", "localhost:81"], ["127.0.0.6:81"]),
    ],
)
def test_the_names_of_a_server_for_others(
    bound: str, address: tuple[str, int], served: list[str], refused: list[str]
) -> None:
    door = make_door(bound, token="secret")
    assert [door.serves(host, address) for host in served] == [True] * len(served)
    assert [door.serves(host, address) for host in refused] == [False] * len(refused)


@pytest.mark.skipif(address_for_others() is None, reason="this machine is on no network")
def test_others_come_in_by_the_link_for_them(serve: Serve) -> None:
    app = serve(host="0.0.0.0", token=TOKEN)
    assert app.link_for_others is not None
    page = WireBrowser(app.link_for_others)
    page.widget("Motion")
    page.leave()
    assert serve().link_for_others is None


def test_the_port_that_browsers_leave_out_is_the_same_origin() -> None:
    door = Door("127.0.0.1")
    assert door.trusts("http://127.0.0.1", "127.0.0.1:80")
    assert door.trusts("http://127.0.0.1", "127.0.0.1")
    assert not door.trusts("http://127.0.0.1", "127.0.0.1:8080")


def test_a_refusal_is_said_once(app: App, caplog: pytest.LogCaptureFixture) -> None:
    for _ in range(3):
        knock(app, Origin="http://evil.example")
    for number in range(100):
        knock(app, Origin=f"http://{number}.example")
    lines = [record.getMessage() for record in caplog.records]
    assert sum("http://evil.example" in line for line in lines) == 1
    assert len(lines) == 20
    assert all("\n" not in line for line in lines)


@pytest.mark.parametrize("headers", [{"Accept_Encoding": "x"}, {}])
def test_a_request_that_viser_cannot_read_harms_nobody(
    app: App, headers: dict[str, str], caplog: pytest.LogCaptureFixture
) -> None:
    for path in ("/%00", "/" + "a" * 5000, "/../../etc/passwd", "/%2e%2e/x", "//x", "http://x/"):
        assert ask(app, path, **headers).status in (400, 404)
    assert "Traceback" not in caplog.text
    works(app)


# --- the token ---
def test_without_the_token_there_is_no_page_and_no_session(serve: Serve) -> None:
    app = serve(token=TOKEN)
    for path in ("/", "/index.html", "/?token=wrong", "/?token=", "/nothing"):
        page = ask(app, path)
        assert page.status == 403
        assert page.headers["content-type"].startswith("text/html")
        assert "set-cookie" not in page.headers
        assert ("not the right one" in page.text) == ("token=" in path)
        assert knock(app, path).status == 403
    assert app.sessions == {}
    with pytest.raises(InvalidStatus, match="403"):
        WireBrowser(app.url)
    assert TOKEN not in page.text


def test_the_link_opens_the_page_and_is_forgotten(serve: Serve) -> None:
    app = serve(token=TOKEN)
    assert app.link.startswith(f"{app.url}/?token=")
    first = ask(app, app.link.removeprefix(app.url) + "&fixedDpr=1")
    assert first.status == 302
    assert first.headers["location"] == "/?fixedDpr=1"
    assert first.headers["cache-control"] == "no-store"
    flags = first.headers["set-cookie"].split("; ")[1:]
    assert set(flags) == {"Path=/", "HttpOnly", "SameSite=Lax"}
    assert TOKEN not in first.cookie
    assert ask(app, Cookie=first.cookie).status == 200
    assert ask(app, Cookie=f"other=1; {first.cookie}; more").status == 200
    assert knock(app, Cookie=first.cookie).status == CAME_IN
    works(app, headers={"Cookie": first.cookie})
    # A link of before does no harm to who is in already.
    again = ask(app, "/?token=wrong", Cookie=first.cookie)
    assert (again.status, again.headers["location"]) == (302, "/")


def test_a_tool_says_the_token_with_its_request(serve: Serve) -> None:
    app = serve(token=TOKEN)
    works_at = WireBrowser(app.link)
    works_at.widget("Motion")
    works_at.leave()


def test_the_token_does_not_replace_the_origin(serve: Serve) -> None:
    app = serve(token=TOKEN)
    cookie = ask(app, app.link.removeprefix(app.url)).cookie
    assert knock(app, Cookie=cookie, Origin="http://evil.example").status == 403
    assert ask(app, host="evil.example", Cookie=cookie).status == 403


def test_a_ticket_is_of_one_server_and_one_token(serve: Serve) -> None:
    first, second, other = serve(token=TOKEN), serve(token=TOKEN), serve(token="another")
    cookie = ask(first, first.link.removeprefix(first.url)).cookie
    name, _, value = cookie.partition("=")
    assert str(port_of(first)) in name
    assert ask(second, Cookie=cookie).status == 403
    moved = name.replace(str(port_of(first)), str(port_of(other)))
    assert ask(other, Cookie=f"{moved}={value}").status == 403
    assert ask(first, Cookie=f"{name}={value[:-1]}").status == 403
    assert ask(first, Cookie=f"{name}=\xe4").status == 403


def test_a_server_that_was_started_again_knows_its_pages() -> None:
    address, own = ("127.0.0.1", 8080), {"Host": "127.0.0.1:8080"}
    answer = Door("127.0.0.1", "x").answer(Request("/?token=x", Headers(own)), address)
    assert answer is not None
    kept = Headers({**own, "Cookie": answer.headers["Set-Cookie"].partition(";")[0]})
    assert Door("127.0.0.1", "x").answer(Request("/", kept), address) is None


@pytest.mark.parametrize(
    ("origins", "frames", "host", "flags"),
    [
        ((), (), "127.0.0.1:8080", {"SameSite=Lax"}),
        ((), ("https://course.example",), "127.0.0.1:8080", {"SameSite=Lax"}),
        (("https://lab.example",), (), "lab.example", {"SameSite=Lax", "Secure"}),
        (("http://lab.example",), (), "lab.example", {"SameSite=Lax"}),
        (
            ("https://lab.example",),
            ("https://course.example",),
            "lab.example",
            {"SameSite=None", "Secure", "Partitioned"},
        ),
    ],
)
def test_the_cookie_goes_where_the_page_is_shown(
    origins: tuple[str, ...], frames: tuple[str, ...], host: str, flags: set[str]
) -> None:
    door = make_door("127.0.0.1", token="x", allow_origins=origins, allow_frames=frames)
    answer = door.answer(Request("/?token=x", Headers({"Host": host})), ("127.0.0.1", 8080))
    assert answer is not None
    assert set(answer.headers["Set-Cookie"].split("; ")[1:]) == flags | {"Path=/", "HttpOnly"}


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"host": "0.0.0.0"}, "--token"),
        ({"host": ""}, "--token"),
        ({"host": "::"}, "--no-token"),
        ({"host": "192.0.2.1"}, "--token"),
        ({"host": "localhost.example"}, "--token"),
        ({"host": "127.0.0.1.example"}, "--token"),
        ({"token": "x", "no_token": True}, "--no-token"),
        ({"token": ""}, "--token"),
        ({"token": "two words"}, "--token"),
        ({"token": "line\n"}, "--token"),
        ({"token": "x" * 1000}, "--token"),
        *(
            ({flag: (text,)}, text)
            for flag in ("allow_origins", "allow_frames")
            for text in (
                "*", "course.example", "https://", "ftp://course.example", "null",
                "https://course.example/page", "https://user@course.example",
                "https://course.example:99999", "https://*.example", "https://a b", "https://a;b",
                "https://a,b", "https://a?b",
            )
        ),
    ],
)  # fmt: skip
def test_what_opens_too_much_is_refused_before_anything_is_loaded(
    options: dict[str, object], says: str
) -> None:
    with pytest.raises(InputError) as refused:
        start(ServerOptions(checkpoints=("nope",), port=0, **options))  # type: ignore[arg-type]
    assert says in str(refused.value)
    assert "nope" not in str(refused.value)
    assert "\n" not in str(refused.value)


def test_each_refusal_offers_another_token() -> None:
    offers = set()
    for _ in range(3):
        with pytest.raises(InputError) as refused:
            make_door("0.0.0.0")
        offers.add(str(refused.value))
    assert len(offers) == 3


@pytest.mark.parametrize("host", ["127.0.0.1", "127.8.9.1", "localhost", "::1"])
def test_this_machine_alone_needs_no_token(host: str) -> None:
    assert make_door(host).token is None


# --- what the page is served with ---
@pytest.mark.parametrize(
    ("path", "clean"),
    [
        ("/?websocket=ws://evil.example", "/"),
        ("/?playbackPath=https://evil.example/x.viser", "/"),
        ("/?%77ebsocket=x", "/"),
        ("/?websocket", "/"),
        ("/?a=1&websocket=x&websocket=y&b=%26", "/?a=1&b=%26"),
        ("/index.html?websocket=x", "/index.html"),
        ("//evil.example/?websocket=x", "/evil.example/"),
        ("/\\evil.example/?playbackPath=x", "/evil.example/"),
        ("/?token=of-another-time&fixedDpr=1", "/?fixedDpr=1"),
    ],
)
def test_what_leads_the_page_elsewhere_is_taken_out_of_its_address(
    app: App, path: str, clean: str
) -> None:
    answer = ask(app, path)
    assert answer.status == 302
    assert answer.headers["location"] == clean


@pytest.mark.parametrize("path", ["/?fixedDpr=1", "/?Websocket=x", "/?x=websocket=y", "/?"])
def test_other_parameters_are_the_pages_own(app: App, path: str) -> None:
    assert ask(app, path).status == 200


@pytest.mark.parametrize("path", ["/", "/nothing", "/?websocket=x"])
def test_every_answer_says_what_the_page_may_do(app: App, path: str) -> None:
    answer = ask(app, path)
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["referrer-policy"] == "no-referrer"
    assert answer.headers["x-frame-options"] == "DENY"
    assert answer.headers["cross-origin-resource-policy"] == "same-origin"
    policy = answer.policy
    host = app.url.removeprefix("http://")
    assert policy["default-src"] == policy["object-src"] == policy["base-uri"] == "'none'"
    assert policy["form-action"] == policy["frame-ancestors"] == "'none'"
    assert set(policy["connect-src"].split()) == {"'self'", "blob:", "data:", f"ws://{host}"}
    assert "'unsafe-inline'" not in policy["script-src"]
    for directive, sources in policy.items():
        assert not {"*", "http:", "https:", "ws:", "wss:"} & set(sources.split()), directive


def test_only_a_page_that_was_named_may_embed_it(serve: Serve) -> None:
    app = serve(allow_frames=("https://Course.example/", "http://lab:81"), token="x")
    for answer in (ask(app), ask(app, Cookie=ask(app, "/?token=x").cookie)):
        assert answer.policy["frame-ancestors"] == "https://course.example http://lab:81"
        assert "x-frame-options" not in answer.headers
    # It may show the page, not use it.
    assert knock(app, "/?token=x", Origin="https://course.example").status == 403
