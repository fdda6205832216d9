-- End every link of a session: nobody joins by them, and the gateways close who came by them.
-- ARGV: session. Returns how many were ended.

local links_key = 'diaphane:session:' .. ARGV[1] .. ':links'
local ended = 0
for _, hash in ipairs(redis.call('SMEMBERS', links_key)) do
  redis.call('DEL', 'diaphane:link:' .. hash)
  -- A link that is merely not there may have been lost with Redis: who came by it stays.
  redis.call('SET', 'diaphane:link:' .. hash .. ':ended', '1', 'EX', 86400)
  ended = ended + 1
end
redis.call('DEL', links_key)
return ended
