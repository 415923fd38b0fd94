"""What a lecturer edits, and its readers: the exercises, the settings of a course, the messages.

The sentences themselves are in messages/; checks are in checks/.
"""
