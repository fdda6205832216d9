/**
 * Prevents flicks on elements that a finger drags (touch-action: none). A finger that is lifted
 * while it moves causes a flick, and Chromium takes a tap within the next second for the end of the
 * flick, so no button gets a click. Preventing the default of the moves prevents the flick.
 */
export const noFlick = (event: TouchEvent): void => {
  if (event.cancelable) event.preventDefault();
};
