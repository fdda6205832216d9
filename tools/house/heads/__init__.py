"""How well a head is recognised: volumes real and made, each with what it shows, and the table of what is said of them."""
