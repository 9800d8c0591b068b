"""One file a format of order tables; `registry` lists them."""
