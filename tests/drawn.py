"""A mechanism drawn, mode beside mode, and on its page."""

import matplotlib

import pmjac_pin as pj


def draws_and_shows(mechanism, actuated, folder):
    """Tell whether there is a picture of all modes and a page of one."""
    matplotlib.use("Agg")
    from pmjac_pin.pictures.mode_sheet import plot_modes

    page = folder / "page.html"
    with pj.view(mechanism.close(actuated), open_browser=False, port=0) as viewer:
        viewer.save_html(page)
    modes = pj.assembly_modes(mechanism, actuated, rng=0)
    drawn = sum(len(sheet.axes) for sheet in plot_modes(modes))
    return drawn >= len(modes) > 0 and page.stat().st_size > 0
