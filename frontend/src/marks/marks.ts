import { computed, signal } from "@preact/signals";
import { mostMarks, nextId, shortText, withSet, type Mark, type MarkKind } from "./mark";

/** Maximum number of steps that can be undone. */
const mostSteps = 100;

/** A mark that someone else shows, with their number in the session. */
export interface OthersMark {
  readonly number: number;
  readonly mark: Mark;
}

/** Returns the key of a mark among those of all participants. */
export const keyOf = (number: number, id: number): string => `${number}.${id}`;

/** The marks of this viewer, and those that the others show. */
export class Marks {
  readonly items = signal<readonly Mark[]>([]);
  readonly others = signal<ReadonlyMap<number, readonly Mark[]>>(new Map());
  /** The keys of the marks that lie behind matter in the shown picture. */
  readonly hidden = signal<ReadonlySet<string>>(new Set());
  /** Whether marks are drawn. */
  readonly shown = signal(true);
  /** Whether the window of the marks is open, so that they have handles. */
  readonly editing = signal(false);
  /** The kind of mark that the next press creates. */
  readonly tool = signal<MarkKind | null>(null);
  readonly colour = signal(0);
  readonly selected = signal<number | null>(null);
  /** The sets of others, whose marks this viewer cannot change. */
  readonly locked = signal<ReadonlySet<string>>(new Set());
  private readonly past = signal<readonly (readonly Mark[])[]>([]);
  private readonly future = signal<readonly (readonly Mark[])[]>([]);
  /** The change in progress, such as a drag or typing. Its first state is the step to undo. */
  private open: string | null = null;

  readonly canUndo = computed(() => this.past.value.length > 0);
  readonly canRedo = computed(() => this.future.value.length > 0);
  readonly isFull = computed(() => this.items.value.length >= mostMarks);
  readonly othersList = computed<readonly OthersMark[]>(() =>
    [...this.others.value].flatMap(([number, marks]) => marks.map((mark) => ({ number, mark }))),
  );

  /** Adds a mark and selects it. Returns null if there are too many. */
  add(mark: Omit<Mark, "id">): Mark | null {
    if (this.isFull.value) return null;
    const added = { ...mark, id: nextId(this.items.value) };
    this.commit("", [...this.items.value, added]);
    this.selected.value = added.id;
    return added;
  }

  /** Changes a mark. Changes with the same name are one step until `rest` is called. */
  change(name: string, id: number, change: (mark: Mark) => Mark): void {
    if (!this.find(id)) return; // it was deleted meanwhile
    this.commit(
      `${name} ${id}`,
      this.items.value.map((mark) => (mark.id === id ? change(mark) : mark)),
    );
  }

  setText(id: number, text: string): void {
    this.change("text", id, (mark) => ({ ...mark, text: shortText(text) }));
  }

  /** Ends the current step, so that the next change starts a new one. */
  rest(): void {
    this.open = null;
  }

  remove(id: number): void {
    if (this.selected.value === id) this.selected.value = null;
    this.commit(
      "",
      this.items.value.filter((mark) => mark.id !== id),
    );
  }

  /** Whether this viewer can change a mark. */
  isOwn({ set }: Mark): boolean {
    return set === undefined || !this.locked.value.has(set);
  }

  /** Removes all marks that this viewer can change. */
  clear(): void {
    this.selected.value = null;
    this.commit(
      "",
      this.items.value.filter((mark) => !this.isOwn(mark)),
    );
  }

  find(id: number | null): Mark | null {
    return this.items.value.find((mark) => mark.id === id) ?? null;
  }

  undo(): void {
    this.step(this.past, this.future);
  }

  redo(): void {
    this.step(this.future, this.past);
  }

  /** Adds the marks of a saved set, which cannot be undone. */
  show(set: string, marks: readonly Mark[]): void {
    let items = this.items.value.filter((mark) => mark.set !== set);
    for (const mark of marks) items = [...items, { ...mark, id: nextId(items), set }];
    this.replace(items);
  }

  hide(set: string): void {
    this.replace(this.items.value.filter((mark) => mark.set !== set));
  }

  /** Moves the marks of a set to another one. Undefined stands for those that are not saved. */
  retag(from: string | undefined, to: string | undefined): void {
    this.replace(this.items.value.map((mark) => (mark.set === from ? withSet(mark, to) : mark)));
  }

  /**
   * Replaces the marks and clears the steps to undo, which would bring back what was removed on
   * purpose.
   */
  replace(items: readonly Mark[]): void {
    this.items.value = items;
    this.past.value = [];
    this.future.value = [];
    this.open = null;
    if (!this.find(this.selected.value)) this.selected.value = null;
  }

  private commit(name: string, items: readonly Mark[]): void {
    if (name === "" || name !== this.open) this.past.value = [...this.past.value, this.items.value].slice(-mostSteps);
    this.open = name;
    this.future.value = [];
    this.items.value = items;
  }

  private step(from: typeof this.past, to: typeof this.past): void {
    const back = from.value.at(-1);
    if (!back) return;
    to.value = [...to.value, this.items.value];
    from.value = from.value.slice(0, -1);
    this.items.value = back;
    this.open = null;
    if (!this.find(this.selected.value)) this.selected.value = null;
  }
}
