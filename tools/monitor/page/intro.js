// What is seen, in three sentences, for who opens the page for the first time; and how to drive with what is at hand.

const touch = matchMedia("(pointer: coarse)");
const NUMBERS = ["no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"];

export const WHAT_PICTURES_ARE = "Each picture is the world as one program sees it; a pink line leads from where it shows a thing to where that really is.";

/** How an avatar is driven on this device, to follow "Drive an avatar:". */
export function howToDrive() {
  return touch.matches ? "touch a picture, and hold a finger where its avatar shall go" : "click a picture, then press WASD or the arrow keys";
}

export function howToDriveOn(slot) {
  return touch.matches
    ? `You drive avatar ${slot}. Hold a finger where it shall go.`
    : `You drive avatar ${slot} with WASD, the arrow keys, or the mouse button held where it shall go. Esc lets go.`;
}

export function intro(session) {
  const count = session.present().length;
  if (session.hello?.mode === "capture") return "This is the world that the peers agreed on, rebuilt from their packets alone. A thing has the colour of the peer that decides about it. Play it, or drag the slider.";
  if (count === 0) return "";
  if (session.waits()) return `${count === 1 ? "One program is" : `${capital(NUMBERS[count] ?? String(count))} programs are`} here, and ${count === 1 ? "it waits" : "they wait"} for more, as --wait-peers says. Nothing moves until all have come.`;
  const waits = count === 1 && !session.replayed() ? " It is alone: others may join, and with --wait-peers it waits for them." : "";
  const programs = count === 1 ? "One program plays" : `${capital(NUMBERS[count] ?? String(count))} programs play`;
  const was = session.replayed() ? "This is a recording: play it, or drag the slider." : session.drivable().length > 0 ? `Drive an avatar: ${howToDrive()}.` : session.offline ? "" : "This page may only look.";
  return `${programs} in one world without a server, and each picture is the world as one of them sees it. `
    + `A thing has the colour of the peer that decides about it; a pink line leads from where a picture shows it to where it really is. ${was}${waits}`;
}

function capital(word) {
  return word[0].toUpperCase() + word.slice(1);
}
