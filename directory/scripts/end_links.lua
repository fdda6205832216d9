-- End every link of a session: nobody joins by them, and the gateways close who came by them.
-- ARGV: session. Returns how many were ended.

local links_key = keys.session_links(ARGV[1])
local ended = 0
for _, hash in ipairs(redis.call('SMEMBERS', links_key)) do
  redis.call('DEL', keys.link(hash))
  -- A link that is merely not there may have been lost with Redis: who came by it stays.
  redis.call('SET', keys.link_ended(hash), '1', 'EX', kLinkEndedS)
  ended = ended + 1
end
redis.call('DEL', links_key)
return ended
