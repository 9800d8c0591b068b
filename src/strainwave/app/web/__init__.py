"""The local web app: a server of one page, and the JSON API that the page uses."""
