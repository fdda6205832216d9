/**
 * For what a finger drags by itself (touch-action: none). Lifted while it still moves, a finger flicks; Chromium takes the next
 * tap within a second for the end of that flick, and no button gets a click of it. A move that was taken is no flick's.
 */
export const noFlick = (event: TouchEvent): void => {
  if (event.cancelable) event.preventDefault();
};
