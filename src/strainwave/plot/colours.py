"""Colours that colour-blind people tell apart (Okabe and Ito), and dashes for readers without colours."""

BLUE, ORANGE, GREEN, PINK = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
BLACK, GREY, PALE = "#222222", "#777777", "#c0c0c0"
DASHES, DOT_DASH, DOTS = "6 3", "8 3 2 3", "2 2"
LOOKS = (
    (BLUE, ""), (ORANGE, DASHES), (GREEN, DOTS), (PINK, "10 3"), (GREY, ""), (BLUE, DOTS), (ORANGE, DOT_DASH),
    (GREEN, ""), (PINK, DASHES), (GREY, DOTS),
)  # fmt: skip
