"""What changes about a person between one day and another?"""
