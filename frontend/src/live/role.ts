import type { Audience, Participant } from "../protocol/messages";

/** What this page may do in a live session. It presents while it is alone or nothing is known yet. */
export interface Role {
  readonly you: string;
  readonly people: readonly Participant[];
  readonly others: number;
  readonly presents: boolean;
  /** Whether someone else is presenting. */
  readonly follows: boolean;
  readonly freeCamera: boolean;
  /** Whether the viewer came by a link to someone's session. A guest can't change what is cut away. */
  readonly guest: boolean;
  /** Null while the presenter is disconnected. */
  readonly presenter: Participant | null;
}

export function roleOf(audience: Audience | null): Role {
  const people = audience?.participants ?? [];
  const you = audience?.you ?? "";
  const presents = audience === null || audience.presenter === you;
  return {
    you,
    people,
    others: people.filter(({ id }) => id !== you).length,
    presents,
    follows: !presents,
    freeCamera: people.find(({ id }) => id === you)?.freeCamera ?? false,
    guest: people.some(({ id, owner }) => id === you && !owner),
    presenter: people.find(({ presenter }) => presenter) ?? null,
  };
}
