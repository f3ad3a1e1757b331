#include "tasks/common/procedure_paraphrases.h"

namespace engram {
namespace {

constexpr ParaphraseSet kProcedureSets[] = {
    {"Intercept the rolling ball by moving to its path and deflecting it toward the target.",
     {"Move to the path of the rolling ball and deflect it toward the target.",
      "Intercept the ball that rolls: get into its path and redirect it to the target.",
      "Go where the ball rolls along and deflect it so that it moves toward the target.",
      "Stop the ball's course by moving into its path, and send it toward the target.",
      "Meet the rolling ball on its path and turn it toward the target.",
      "A ball is rolling. Move to its path, intercept it and deflect it toward the target.",
      "Deflect the rolling ball toward the target by moving into its way.",
      "Get in the way of the rolling ball and guide it toward the target.",
      "Catch up with the rolling ball's path and deflect the ball in the target's direction.",
      "Intercept the ball as it rolls, and redirect it toward the target."}},
    {"Intercept the rolling ball and grasp it to stop it.",
     {"Meet the rolling ball and stop it by grasping it.",
      "Catch the rolling ball: grasp it so that it stops.",
      "Grasp the ball while it rolls, and stop it.",
      "Intercept the ball that rolls and close the gripper on it to stop it.",
      "A ball is rolling. Intercept it, grasp it and stop it.",
      "Stop the rolling ball by intercepting and grasping it.",
      "Go to the rolling ball and grasp it to bring it to a stop.",
      "Take hold of the rolling ball so that it no longer moves.",
      "Get hold of the ball as it rolls by, and stop it.",
      "Reach for the rolling ball, grasp it, and stop it."}},
    {"Rotate the peg by {angle_deg} degrees to match the target angle.",
     {"Turn the peg by {angle_deg} degrees, so that it has the target angle.",
      "Rotate the peg {angle_deg} degrees to reach the target angle.",
      "Make the peg turn by {angle_deg} degrees to match the target angle.",
      "The peg has to be rotated by {angle_deg} degrees to the target angle.",
      "Bring the peg to the target angle by rotating it {angle_deg} degrees.",
      "Turn the peg {angle_deg} degrees; then it matches the target angle.",
      "Give the peg a rotation of {angle_deg} degrees to match the target angle.",
      "To match the target angle, rotate the peg by {angle_deg} degrees.",
      "Rotate the peg until it has turned by {angle_deg} degrees, which is the target angle.",
      "Change the peg's angle by {angle_deg} degrees to the target angle."}},
    {"Rotate the peg by {angle_deg} degrees to match the target angle while keeping the center of "
     "the peg in place.",
     {"Turn the peg by {angle_deg} degrees to the target angle, and keep its center in place.",
      "Rotate the peg {angle_deg} degrees to reach the target angle without moving its center.",
      "Make the peg turn by {angle_deg} degrees to match the target angle; its center stays where "
      "it is.",
      "The peg has to be rotated by {angle_deg} degrees to the target angle, with its center in "
      "place.",
      "Bring the peg to the target angle by rotating it {angle_deg} degrees about its center.",
      "Turn the peg {angle_deg} degrees, so that it matches the target angle, and do not shift its "
      "center.",
      "Give the peg a rotation of {angle_deg} degrees to match the target angle, and leave its "
      "center in place.",
      "To match the target angle, rotate the peg by {angle_deg} degrees while its center stays in "
      "place.",
      "Keep the center of the peg where it is, and rotate the peg by {angle_deg} degrees to the "
      "target angle.",
      "Change the peg's angle by {angle_deg} degrees to the target angle, but not the place of its "
      "center."}},
    {"Push the cube onto the red target, and when the target changes color, return the cube to its "
     "original position.",
     {"Push the cube to the red target; when the target's color changes, bring the cube back to "
      "where it was.",
      "Move the cube onto the red target. As soon as the target changes color, return the cube to "
      "its first position.",
      "Bring the cube onto the target, which is red, and back to its original place when the "
      "target changes color.",
      "Put the cube on the red target, and when that has another color, take the cube back to its "
      "original position.",
      "First push the cube onto the red target; after the target's change of color, return it to "
      "where it started.",
      "Push the cube until it is on the red target. When the target's color changes, move the cube "
      "back to its original position.",
      "Take the cube to the red target, and once the target changes color, return it to the "
      "position it had at first.",
      "The cube belongs onto the red target until the target changes color; then return it to its "
      "original position.",
      "Push the cube onto the red target, wait for the target to change color, and put the cube "
      "back where it was.",
      "When you have pushed the cube onto the red target and the target changes color, return the "
      "cube to its original position."}},
    {"Observe which colored cubes appear during the cue, wait, then touch all of them in any order "
     "and press the center button.",
     {"Look which colored cubes appear in the cue, wait, then touch each of them, in any order, "
      "and press the center button.",
      "Remember the colors of the cubes in the cue. After waiting, touch these cubes in any order "
      "and press the button in the center.",
      "Watch the colored cubes of the cue, wait, touch all of them in whatever order, and press "
      "the center button.",
      "Note the cubes that appear during the cue, wait, touch every one of them, then press the "
      "center button; the order does not matter.",
      "First see which colored cubes the cue has; then wait; then touch all of these in any order "
      "and press the center button.",
      "Keep the colored cubes of the cue in mind, wait, touch them all, the order is free, and "
      "press the center button.",
      "Colored cubes appear during the cue. Wait, touch all of them in any order, and press the "
      "center button.",
      "Memorize which colored cubes the cue shows, wait, then touch them in any order and push the "
      "center button.",
      "After the cue and the wait, touch all colored cubes that appeared, in any order, and press "
      "the center button.",
      "Touch, in any order, all colored cubes that appeared during the cue, once you have waited; "
      "then press the center button."}},
    {"Observe which colored cubes appear during the cue, wait, then touch all of them in the same "
     "order as the cubes were shown and press the center button.",
     {"Look which colored cubes appear in the cue, wait, then touch each of them in the order in "
      "which they were shown, and press the center button.",
      "Remember the colors of the cubes in the cue and their order. After waiting, touch these "
      "cubes in that order and press the button in the center.",
      "Watch the colored cubes of the cue, wait, touch all of them in the same order, and press "
      "the center button.",
      "Note the cubes that appear during the cue, wait, touch every one of them in the order "
      "shown, then press the center button.",
      "First see which colored cubes the cue has; then wait; then touch all of these in the cue's "
      "order and press the center button.",
      "Keep the colored cubes of the cue and their order in mind, wait, touch them all in this "
      "order, and press the center button.",
      "Colored cubes appear during the cue. Wait, touch all of them in the order of their "
      "appearance, and press the center button.",
      "Memorize in which order the cue shows which colored cubes, wait, then touch them in the "
      "same order and push the center button.",
      "After the cue and the wait, touch all colored cubes that appeared, in the order in which "
      "they did, and press the center button.",
      "Touch all colored cubes that appeared during the cue, in the same order, once you have "
      "waited; then press the center button."}},
    {"Observe which colored cubes appear during the cue, wait, then touch all of them in any "
     "order.",
     {"Look which colored cubes appear in the cue, wait, then touch each of them, in any order.",
      "Remember the colors of the cubes in the cue. After waiting, touch these cubes in any order.",
      "Watch the colored cubes of the cue, wait, and touch all of them in whatever order.",
      "Note the cubes that appear during the cue, wait, then touch every one of them; the order "
      "does not matter.",
      "First see which colored cubes the cue has; then wait; then touch all of these in any order.",
      "Keep the colored cubes of the cue in mind, wait, and touch them all; the order is free.",
      "Colored cubes appear during the cue. Wait, and touch all of them in any order.",
      "Memorize which colored cubes the cue shows, wait, then touch them in any order.",
      "After the cue and the wait, touch all colored cubes that appeared, in any order.",
      "Touch, in any order, all colored cubes that appeared during the cue, once you have "
      "waited."}},
    {"Observe which colored cubes appear during the cue, wait, then touch all of them in the same "
     "order as the cubes were shown.",
     {"Look which colored cubes appear in the cue, wait, then touch each of them in the order in "
      "which they were shown.",
      "Remember the colors of the cubes in the cue and their order. After waiting, touch these "
      "cubes in that order.",
      "Watch the colored cubes of the cue, wait, and touch all of them in the same order.",
      "Note the cubes that appear during the cue, wait, then touch every one of them in the order "
      "shown.",
      "First see which colored cubes the cue has; then wait; then touch all of these in the cue's "
      "order.",
      "Keep the colored cubes of the cue and their order in mind, wait, and touch them all in this "
      "order.",
      "Colored cubes appear during the cue. Wait, and touch all of them in the order of their "
      "appearance.",
      "Memorize in which order the cue shows which colored cubes, wait, then touch them in the "
      "same order.",
      "After the cue and the wait, touch all colored cubes that appeared, in the order in which "
      "they did.",
      "Touch all colored cubes that appeared during the cue, in the same order, once you have "
      "waited."}},
    {"Count how many times the blue lamp blinks, press the red button exactly that many times when "
     "the red lamp turns green, then press the black button to submit your answer.",
     {"Count the blinks of the blue lamp. When the red lamp turns green, press the red button as "
      "many times, then submit with the black button.",
      "Watch how often the blue lamp blinks; once the red lamp turns green, press the red button "
      "exactly as often, and then the black button to submit.",
      "Remember the number of times that the blue lamp blinks, press the red button that many "
      "times when the red lamp is green, and press the black button.",
      "The blue lamp blinks: count it. After the red lamp has turned green, press the red button "
      "just as many times and submit your answer with the black button.",
      "Press the red button exactly as many times as the blue lamp blinked, when the red lamp "
      "turns green; then press the black button to submit.",
      "Count each blink of the blue lamp, wait for the red lamp to turn green, press the red "
      "button once for every blink, then press the black button.",
      "See how many times the blue lamp blinks. As soon as the red lamp turns green, press the red "
      "button the same number of times and then the black button.",
      "Keep count of the blue lamp's blinks; when the red lamp changes to green, repeat the count "
      "on the red button, and submit it with the black one.",
      "First count how many times the blue lamp blinks; when the red lamp turns green, press the "
      "red button so many times; at last press the black button to submit.",
      "When the red lamp turns green, press the red button once for each time the blue lamp "
      "blinked, and submit your answer by pressing the black button."}},
    {"When the white lamp turns green, start counting steps from that exact moment. Move the blue "
     "cube from the green disc to the red disc exactly on step {steps} of that count.",
     {"Start to count steps at the moment the white lamp turns green. On step {steps} of the "
      "count, move the blue cube from the green disc to the red disc.",
      "Count steps from when the white lamp turns green, and bring the blue cube from the green "
      "disc to the red disc exactly on step {steps}.",
      "As soon as the white lamp is green, begin to count steps. The blue cube has to move from "
      "the green disc to the red disc on step {steps}.",
      "Move the blue cube from the green disc to the red one exactly {steps} steps after the white "
      "lamp turns green.",
      "The white lamp's turning green begins a count of steps. Exactly on its step {steps}, move "
      "the blue cube from the green to the red disc.",
      "Watch the white lamp. From the moment it turns green count the steps, and on step {steps} "
      "move the blue cube from the green disc to the red disc.",
      "Wait until the white lamp turns green, count steps from there, and transfer the blue cube "
      "from the green disc to the red disc exactly on step {steps}.",
      "Count from the white lamp's change to green. On exactly step {steps} of this count, put the "
      "blue cube from the green disc onto the red disc.",
      "On step {steps} of a count that starts when the white lamp turns green, move the blue cube "
      "from the green disc to the red disc.",
      "The blue cube goes from the green disc to the red disc exactly on step {steps}, counted "
      "from the moment at which the white lamp turns green."}},
    {"Move all cubes onto the disc. A lamp will briefly flash while you work. After all cubes are "
     "placed, press the button matching the flash color.",
     {"Put all cubes on the disc. Meanwhile a lamp flashes briefly. When all cubes are there, "
      "press "
      "the button with the color of the flash.",
      "Bring every cube onto the disc and watch for a brief flash of a lamp. After the last cube, "
      "press the button that matches the flash's color.",
      "Gather all cubes on the disc; while you work, a lamp will flash for a short time. Then "
      "press the button of that color.",
      "All cubes go onto the disc. Remember the color in which a lamp briefly flashes during the "
      "work, and in the end press the button of this color.",
      "Place all cubes on the disc. A lamp flashes briefly in between. Once all are placed, press "
      "the button matching its color.",
      "Collect the cubes on the disc, note the color of the lamp's brief flash as you work, and "
      "press the matching button after all cubes are placed.",
      "Move each cube to the disc. There will be a brief flash of a lamp. When all cubes are on "
      "the disc, press the button in the flash's color.",
      "While you move all cubes onto the disc, a lamp briefly flashes. After that work, press the "
      "button whose color is that of the flash.",
      "After you have moved all cubes onto the disc, press the button that has the color in which "
      "a lamp briefly flashed while you worked.",
      "First all cubes have to be on the disc; then press the button with the color of the lamp "
      "that briefly flashes during the work."}},
    {"Find all working batteries by inserting each one into the socket, observing the lamp result, "
     "and then pressing the button to confirm.",
     {"Find the batteries that work: insert each into the socket, look at the lamp, and press the "
      "button to confirm.",
      "Insert one battery after the other into the socket, see what the lamp shows, press the "
      "button to confirm, and so find all that work.",
      "Test each battery in the socket: observe the lamp's result, then confirm with the button, "
      "until all working batteries are found.",
      "Put each battery into the socket, watch the lamp, and confirm by pressing the button, to "
      "find every working battery.",
      "To find all working batteries, insert each one into the socket, observe the lamp, and then "
      "press the button.",
      "All working batteries have to be found. Insert each battery into the socket, watch the "
      "lamp's result, and confirm it with the button.",
      "Check the batteries one at a time: into the socket, look at the lamp, press the button to "
      "confirm. Find all that work.",
      "Discover which batteries work. For each, insert it into the socket, observe the lamp, and "
      "press the button to confirm.",
      "With the socket, the lamp and the button, find all working batteries: insert each one, "
      "observe the result, confirm.",
      "Insert each battery into the socket and observe the lamp; press the button to confirm; find "
      "all batteries that work."}},
    {"Find all working batteries by inserting each one into the socket, observing the lamp result, "
     "returning it from the socket to its initial slot, and then pressing the button to confirm.",
     {"Find the batteries that work: insert each into the socket, look at the lamp, put the "
      "battery "
      "back into its first slot, and press the button to confirm.",
      "Insert one battery after the other into the socket, see what the lamp shows, return the "
      "battery to its slot, press the button to confirm, and so find all that work.",
      "Test each battery in the socket: observe the lamp's result, bring the battery back to its "
      "initial slot, then confirm with the button, until all working batteries are found.",
      "Put each battery into the socket, watch the lamp, return it to the slot it came from, and "
      "confirm by pressing the button, to find every working battery.",
      "To find all working batteries, insert each one into the socket, observe the lamp, move it "
      "back to its initial slot, and then press the button.",
      "All working batteries have to be found. Insert each battery into the socket, watch the "
      "lamp's result, return it to its slot, and confirm it with the button.",
      "Check the batteries one at a time: into the socket, look at the lamp, back to the initial "
      "slot, press the button to confirm. Find all that work.",
      "Discover which batteries work. For each, insert it into the socket, observe the lamp, "
      "return it to its initial slot, and press the button to confirm.",
      "With the socket, the lamp and the button, find all working batteries: insert each one, "
      "observe the result, return it to its slot, confirm.",
      "Insert each battery into the socket and observe the lamp; return it to its initial slot; "
      "press the button to confirm; find all batteries that work."}},
    {"Watch the red cube trace a shape on the table. When the lamp turns green, pick up the green "
     "cube and trace exactly the same shape.",
     {"Watch which shape the red cube traces on the table. As soon as the lamp is green, pick up "
      "the green cube and trace the same shape exactly.",
      "Remember the shape that the red cube traces on the table. When the lamp turns green, take "
      "the green cube and trace it just like that.",
      "The red cube traces a shape on the table. Once the lamp turns green, trace exactly this "
      "shape with the green cube.",
      "Observe the red cube as it traces a shape on the table; when the lamp turns green, pick up "
      "the green cube and repeat the shape exactly.",
      "Look how the red cube draws a shape on the table. When the lamp turns green, pick up the "
      "green cube and draw exactly the same one.",
      "See the red cube trace a shape on the table, wait for the green lamp, then pick up the "
      "green cube and trace the identical shape.",
      "Keep the shape in mind that the red cube traces on the table, and when the lamp turns "
      "green, trace the same with the green cube in your gripper.",
      "First watch the red cube trace a shape on the table; then, when the lamp turns green, pick "
      "up the green cube and copy that shape exactly.",
      "Memorize the shape traced by the red cube on the table; pick up the green cube when the "
      "lamp turns green, and trace the very same shape.",
      "When the lamp turns green, pick up the green cube and trace exactly the shape that you have "
      "watched the red cube trace on the table."}},
    {"Watch the red cube trace a sequence of shapes. When the lamp turns green, pick up the green "
     "cube and trace the same sequence in order. After finishing all shapes, press the button to "
     "submit your answer.",
     {"Watch which shapes the red cube traces one after the other. As soon as the lamp is green, "
      "pick up the green cube and trace them in the same order. Then press the button to submit.",
      "Remember the sequence of shapes that the red cube traces. When the lamp turns green, take "
      "the green cube, trace the sequence in order, and press the button when all are finished.",
      "The red cube traces several shapes in sequence. Once the lamp turns green, trace the same "
      "sequence with the green cube, in order, and submit it with the button.",
      "Observe the red cube as it traces a sequence of shapes; when the lamp turns green, pick up "
      "the green cube, repeat the sequence in order, and press the button at the end.",
      "Look how the red cube draws a sequence of shapes. When the lamp turns green, pick up the "
      "green cube and draw the same ones in order; after the last one, press the button.",
      "See the red cube trace shapes in sequence, wait for the green lamp, then pick up the green "
      "cube and trace them in that order. Submit your answer with the button.",
      "Keep in mind which shapes the red cube traces and in which order. When the lamp turns "
      "green, trace the same with the green cube, then press the button to submit.",
      "First watch the red cube trace a sequence of shapes; when the lamp turns green, pick up the "
      "green cube and copy the sequence in order; finally press the button.",
      "Memorize the sequence of shapes traced by the red cube; pick up the green cube when the "
      "lamp turns green, trace the sequence in order, and press the button after all shapes.",
      "When the lamp turns green, pick up the green cube and trace, in order, the sequence of "
      "shapes that the red cube has traced; press the button once all shapes are finished."}},
};

}  // namespace

std::span<const ParaphraseSet> procedure_paraphrases() { return kProcedureSets; }

}  // namespace engram
