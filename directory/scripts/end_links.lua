-- Disables all links of a session. Nobody can join with them, and the gateways disconnect the guests who did.
-- ARGV: session. Returns the number of disabled links.

local links_key = keys.session_links(ARGV[1])
local ended = 0
for _, hash in ipairs(redis.call('SMEMBERS', links_key)) do
  redis.call('DEL', keys.link(hash))
  -- Marks the link as disabled: one that is merely missing may have been lost with Redis, and its guests stay.
  redis.call('SET', keys.link_ended(hash), '1', 'EX', kLinkEndedS)
  ended = ended + 1
end
redis.call('DEL', links_key)
return ended
