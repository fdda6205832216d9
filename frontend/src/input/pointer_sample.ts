/** What gestures need to know of a pointer event. Positions are in CSS pixels from the element's top left corner. */
export interface PointerSample {
  readonly id: number;
  readonly x: number;
  readonly y: number;
  readonly touch: boolean;
  readonly button: number;
  readonly shift: boolean;
  /** The Ctrl key, or the Command key of a Mac. */
  readonly ctrl: boolean;
}

export function pointerSampleOf(event: PointerEvent, element: HTMLElement): PointerSample {
  const box = element.getBoundingClientRect();
  return {
    id: event.pointerId,
    x: event.clientX - box.left,
    y: event.clientY - box.top,
    touch: event.pointerType === "touch",
    button: event.button,
    shift: event.shiftKey,
    ctrl: event.ctrlKey || event.metaKey,
  };
}
