"""The viewer from Python: update, saving, closing, notebooks; and the drawing commands."""

from __future__ import annotations

import re
import threading
from html.parser import HTMLParser
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.files.shapes import Sphere, Text, scaled
from pmjac_pin.viewer import viewer as viewer_module
from pmjac_pin.viewer.canvas import Canvas
from pmjac_pin.viewer.items import Item
from pmjac_pin.viewer.scene import SceneMaker
from pmjac_pin.viewer.scene_options import SceneOptions


@pytest.fixture
def mechanism():
    return loaded("four_bar")


def decoded(commands):
    return [msgspec.msgpack.decode(command) for _, command in commands]


def test_it_returns_at_once_and_prints_nothing(mechanism, capfd):
    with pj.view(mechanism.home, open_browser=False, port=0) as viewer:
        assert isinstance(viewer, pj.Viewer)
        assert viewer.url == f"http://127.0.0.1:{viewer.port}/"
        assert viewer.url in repr(viewer)
    assert capfd.readouterr() == ("", "")


def test_update(viewer, mechanism):
    there = mechanism.close([1.2])
    viewer.update(there)
    assert viewer.configuration is there
    with pytest.raises(pj.ArgumentError, match="serial_2r"):
        viewer.update(loaded("serial_2r").home)
    with pytest.raises(pj.ArgumentError, match="ndarray"):
        viewer.update(there.q)
    assert viewer.configuration is there


def test_update_from_many_threads(viewer, mechanism):
    poses = [mechanism.close([0.9 + k / 50]) for k in range(20)]
    threads = [threading.Thread(target=viewer.update, args=[pose]) for pose in poses]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert viewer.configuration in poses


def test_what_is_no_configuration(mechanism):
    with pytest.raises(pj.ArgumentError, match=re.escape("mechanism.home")):
        pj.view(mechanism, open_browser=False, port=0)


def test_an_exception_ends_the_server(mechanism):
    with (
        pytest.raises(ZeroDivisionError),
        pj.view(mechanism.home, open_browser=False, port=0) as viewer,
    ):
        raise ZeroDivisionError
    assert viewer.closed


def test_waiting_ends_with_the_viewer(mechanism):
    viewer = pj.view(mechanism.home, open_browser=False, port=0)
    threading.Timer(0.1, viewer.close).start()
    viewer.wait()
    assert viewer.closed


def test_names_that_javascript_knows_are_no_harm(mechanism):
    canvas = Canvas()
    item = Item("links/constructor/__proto__", Sphere(), (0.0, 0.0, 0.0, 1.0), scaled(1.0))
    paths = {command["path"] for command in decoded(canvas.update([item]))}
    assert paths == {"/pmjac/_links/_constructor/___proto__"}


def test_a_closed_viewer(mechanism, tmp_path):
    viewer = pj.view(mechanism.home, open_browser=False, port=0)
    viewer.close()
    viewer.close()
    assert viewer.closed
    assert repr(viewer) == "Viewer(four_bar, closed)"
    with pytest.raises(pj.PmjacError, match="closed"):
        viewer.update(mechanism.home)
    viewer.save_html(tmp_path / "last.html")
    assert (tmp_path / "last.html").stat().st_size > 500_000


def test_save_html(viewer, mechanism, tmp_path):
    path = tmp_path / "x.html"
    viewer.save_html(path)
    first = path.read_text(encoding="utf-8")
    assert "MeshCat" in first
    assert not re.search(r"""(src|href)=["']?http""", first)
    viewer.update(mechanism.close([1.3]))
    viewer.save_html(str(path))
    second = path.read_text(encoding="utf-8")
    assert second != first
    assert abs(len(second) - len(first)) < 2000  # nothing piles up
    assert [file.name for file in tmp_path.iterdir()] == ["x.html"]


def test_a_saved_picture_says_what_it_shows(viewer, mechanism, tmp_path):
    viewer.save_html(tmp_path / "pose.html")
    text = (tmp_path / "pose.html").read_text(encoding="utf-8")
    facts = re.search(r'<aside id="facts">(.*?)</aside>', text, re.DOTALL)[1]
    assert f"<h1>{mechanism.name}</h1>" in facts
    configuration = viewer.configuration
    for name, value in zip(mechanism.actuated, configuration.actuated, strict=True):
        assert f"{name} = {value:.6g} " in facts
    for radius in configuration.jacobian().velocity_ellipsoid().radii:
        assert f"{radius:.4f}" in facts


def test_save_html_keeps_the_mode_of_a_file(viewer, tmp_path):
    path = tmp_path / ("x" * 250 + ".html")
    path.touch()
    path.chmod(0o600)
    viewer.save_html(path)
    assert path.stat().st_mode & 0o777 == 0o600


def test_a_file_that_cannot_be_written(viewer, tmp_path):
    with pytest.raises(OSError, match="nowhere"):
        viewer.save_html(tmp_path / "nowhere" / "x.html")
    (tmp_path / "folder").mkdir()
    with pytest.raises(OSError, match="folder"):
        viewer.save_html(tmp_path / "folder")
    assert [file.name for file in tmp_path.iterdir()] == ["folder"]


def test_in_a_notebook(viewer):
    html = viewer._repr_html_()
    assert html.startswith("<iframe srcdoc=")
    assert 'sandbox="allow-scripts"' in html
    assert html.count("<iframe") == 1
    assert f'<a href="{viewer.url}"' in html
    viewer.close()
    assert "<a href" not in viewer._repr_html_()


@pytest.mark.parametrize("name", ['a"><script>alert(1)</script>', "</title>", "</script>", "ü"])
def test_names_are_escaped(name):
    other = pj.Mechanism.from_pinocchio(
        loaded("serial_2r").model, [], ["theta1", "theta2"], "tip", name=name
    )
    with pj.view(other.home, open_browser=False, port=0) as viewer:
        html = viewer._repr_html_()
    tags = []
    parser = HTMLParser()
    parser.handle_starttag = lambda tag, attributes: tags.append((tag, dict(attributes)))
    parser.feed(html)
    assert [tag for tag, _ in tags] == ["iframe", "p", "a"]
    assert tags[0][1]["title"] == name
    assert set(tags[0][1]) == {"srcdoc", "title", "sandbox", "style"}


OBJECT_NAMES = re.compile(rb"[0-9a-f]{8}-[0-9a-f]{4}-4[0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}")


def test_a_static_scene_is_what_a_viewer_saves(mechanism, tmp_path):
    scene = pj.static_scene(mechanism.close([1.9]), angular=True)
    with pj.view(mechanism.close([1.9]), open_browser=False, port=0, angular=True) as viewer:
        saved = viewer._still()
    assert [OBJECT_NAMES.sub(b"", command) for command in scene.commands] == [
        OBJECT_NAMES.sub(b"", command) for command in saved.commands
    ]
    assert (scene.facts, scene.framing) == (saved.facts, saved.framing)
    assert len(pj.static_scene(mechanism.close([1.9])).commands) < len(scene.commands)
    scene.save(tmp_path / "scene.html")
    assert (tmp_path / "scene.html").read_text(encoding="utf-8") == scene.html()


def test_a_static_scene_in_a_notebook_has_no_link(mechanism):
    html = pj.static_scene(mechanism.home)._repr_html_()
    assert html.startswith("<iframe srcdoc=")
    assert "<a " not in html
    with pytest.raises(pj.ArgumentError, match=re.escape("mechanism.home")):
        pj.static_scene(mechanism)
    with pytest.raises(pj.ArgumentError, match="linear"):
        pj.static_scene(mechanism.home, linear=2)


def test_the_browser_is_opened_when_asked_and_never_in_tests(mechanism, monkeypatch, caplog):
    opened = []
    monkeypatch.setattr(viewer_module.webbrowser, "open", lambda url: bool(opened.append(url)) or 1)
    with pj.view(mechanism.home, port=0) as viewer:
        assert not opened
        assert viewer.url in caplog.text  # so that it is seen
    with pj.view(mechanism.home, open_browser=True, port=0) as viewer:
        assert opened == [viewer.url]
    monkeypatch.setattr(viewer_module.sys, "ps1", ">>> ", raising=False)
    monkeypatch.setenv("DISPLAY", ":0")
    with pj.view(mechanism.home, port=0):
        assert len(opened) == 2


def test_no_browser_is_no_error(mechanism, monkeypatch, caplog):
    monkeypatch.setattr(viewer_module.webbrowser, "open", lambda url: False)
    with pj.view(mechanism.home, open_browser=True, port=0) as viewer:
        assert viewer.url in caplog.text


def test_a_later_picture_sends_transforms_only(mechanism):
    maker, canvas = SceneMaker(mechanism), Canvas()
    canvas.update(maker.scene(mechanism.home).items)
    kinds = {
        command["type"]
        for command in decoded(canvas.update(maker.scene(mechanism.close([0.91])).items))
        if "label" not in command["path"] and "text" not in command["path"]
    }
    assert "set_transform" in kinds
    assert canvas.update(maker.scene(mechanism.close([0.91])).items) == []


def test_the_commands_do_not_pile_up(mechanism):
    maker, canvas = SceneMaker(mechanism), Canvas()
    canvas.update(maker.scene(mechanism.home).items)
    canvas.update(maker.scene(mechanism.close([2.0])).items)
    count = len(canvas.commands())
    for value in np.linspace(0.9, 2.0, 30):
        canvas.update(maker.scene(mechanism.close([value])).items)
    assert len(canvas.commands()) <= count + 10


def test_what_is_not_drawn_any_more_is_hidden(mechanism):
    maker, canvas = SceneMaker(mechanism), Canvas()
    canvas.update(maker.scene(mechanism.home, SceneOptions(linear=True)).items)
    commands = decoded(canvas.update(maker.scene(mechanism.home, SceneOptions(linear=False)).items))
    assert commands
    assert all(c["type"] == "set_property" and c["value"] is False for c in commands)
    again = decoded(canvas.update(maker.scene(mechanism.home, SceneOptions(linear=True)).items))
    assert all(c["type"] == "set_property" and c["value"] is True for c in again)
    assert len(again) == len(commands)


def test_a_label_is_made_anew_only_when_its_text_changes():
    def draw(text, x):
        transform = scaled(0.1)
        transform[0, 3] = x
        return canvas.update([Item("label", Text(text), (0.0, 0.0, 0.0, 1.0), transform)])

    canvas = Canvas()
    assert {c["type"] for c in decoded(draw("1.00", 0.0))} == {
        "set_object",
        "set_transform",
        "set_property",
    }
    assert [c["type"] for c in decoded(draw("1.00", 1.0))] == ["set_transform"]
    (command,) = decoded(draw("1.01", 1.0))
    assert command["object"]["textures"][0]["text"] == "1.01"


def test_transforms_are_column_major_in_metres():
    transform = scaled((1.0, 2.0, 3.0))
    transform[:3, 3] = (4.0, 5.0, 6.0)
    canvas = Canvas()
    commands = decoded(canvas.update([Item("ball", Sphere(), (1.0, 0.5, 0.0, 0.5), transform)]))
    made, moved, _ = (SimpleNamespace(**command) for command in commands)
    assert moved.matrix == [1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 3, 0, 4, 5, 6, 1]
    (material,) = made.object["materials"]
    assert material["color"] == 0xFF8000
    assert material["transparent"]
    assert material["opacity"] == 0.5
