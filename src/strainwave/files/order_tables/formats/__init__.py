"""One file a format of order tables; `order_table` lists them."""
